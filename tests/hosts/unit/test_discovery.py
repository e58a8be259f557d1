"""What each host is told about discovery."""

from __future__ import annotations

import socket

import pytest

from launcher.base.errors import UsageError
from launcher.hosts import discovery
from launcher.hosts.discovery import DEFAULT_PORT, Wiring, address_of, usual_port, wire
from launcher.hosts.file.hosts_model import LOCAL, Discovery, DiscoveryMode, Host

HOSTS = [Host(name="bot1", address="127.0.0.11"), Host(name="bot2", address="127.0.0.12")]
NEUTRAL = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
    "ROS_STATIC_PEERS": "",
    "ROS_DISCOVERY_SERVER": "",
    "ROS_SUPER_CLIENT": "",
    "ROS_LOCALHOST_ONLY": "",
}


def wired(mode: DiscoveryMode, hosts=HOSTS, **settings: object) -> Wiring:
    return wire(Discovery(mode=mode, **settings), hosts)


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch):
    """The address of this machine is another one on the way to each host."""
    monkeypatch.setattr(discovery, "own_address", lambda address: f"{address}9")


@pytest.fixture
def taken_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("", 0))
        yield one.getsockname()[1]


def test_without_a_mode_nothing_is_set():
    wiring = wire(Discovery(), [Host(name="bot", address="no.such.host.invalid")])
    assert wiring.environment_of() == wiring.environment_of("bot") == {}


def test_multicast_undoes_what_the_environment_says():
    wiring = wired(DiscoveryMode.MULTICAST)
    assert wiring.environment_of() == wiring.environment_of("bot1") == NEUTRAL


@pytest.mark.usefixtures("own")
def test_peers_are_the_other_hosts_and_this_machine_as_each_host_sees_it():
    wiring = wired(DiscoveryMode.PEERS)
    of = {name: wiring.environment_of(name) for name in (LOCAL, "bot1", "bot2")}
    assert {name: env["ROS_STATIC_PEERS"] for name, env in of.items()} == {
        LOCAL: "127.0.0.11;127.0.0.12",
        "bot1": "127.0.0.119;127.0.0.12",
        "bot2": "127.0.0.129;127.0.0.11",
    }


def test_peers_are_announced_to_as_many_participants_as_possible():
    environment = wired(DiscoveryMode.PEERS).environment_of()
    assert environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert environment.keys() == NEUTRAL.keys()


def test_hosts_that_share_an_address_are_one_peer():
    hosts = [*HOSTS, Host(name="bot3", address="127.0.0.12")]
    peers = wired(DiscoveryMode.PEERS, hosts).environment_of()["ROS_STATIC_PEERS"]
    assert peers == "127.0.0.11;127.0.0.12"


@pytest.mark.usefixtures("own")
def test_a_server_here_has_the_address_that_each_host_sees():
    wiring = wired(DiscoveryMode.SERVER)
    (server,) = wiring.servers
    assert (server.host, server.listen) == (LOCAL, "0.0.0.0")
    assert wiring.environment_of() == {
        **NEUTRAL,
        "ROS_DISCOVERY_SERVER": f"127.0.0.1:{server.port}",
    }
    assert wiring.environment_of("bot2")["ROS_DISCOVERY_SERVER"] == f"127.0.0.129:{server.port}"


def test_a_server_for_this_machine_alone_is_not_open_to_others():
    (server,) = wired(DiscoveryMode.SERVER, []).servers
    assert server.listen == "127.0.0.1"


def test_a_backup_has_the_second_place_in_the_list():
    wiring = wired(DiscoveryMode.SERVER, server="bot1", backup="bot2")
    assert [one.arguments for one in wiring.servers] == [
        ("0", "0.0.0.0", "11811"),
        ("1", "0.0.0.0", "11811"),
    ]
    servers = "127.0.0.11:11811;127.0.0.12:11811"
    assert wiring.environment_of()["ROS_DISCOVERY_SERVER"] == servers


def test_only_programs_that_read_the_graph_are_super_clients():
    wiring = wired(DiscoveryMode.SERVER)
    assert wiring.graph_environment() == {**wiring.environment_of(), "ROS_SUPER_CLIENT": "TRUE"}
    peers = wired(DiscoveryMode.PEERS)
    assert peers.graph_environment() == peers.environment_of()


def test_a_port_in_use_is_skipped(taken_port: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(discovery, "DEFAULT_PORT", taken_port)
    (server,) = wired(DiscoveryMode.SERVER, []).servers
    assert server.port > taken_port


def test_a_given_port_in_use_is_an_error(taken_port: int):
    with pytest.raises(UsageError, match=f"port {taken_port} .* is in use"):
        wired(DiscoveryMode.SERVER, [], port=taken_port)


def test_ports_of_other_hosts_are_not_tried(taken_port: int):
    (server,) = wired(DiscoveryMode.SERVER, server="bot1", port=taken_port).servers
    assert server.port == taken_port


def test_the_server_must_be_a_host():
    with pytest.raises(UsageError, match="unknown host 'bot7'") as error:
        wired(DiscoveryMode.SERVER, backup="bot7", where="hosts.yaml:9")
    assert error.value.hint == "hosts of the run: local, bot1, bot2"
    assert error.value.where == "hosts.yaml:9"


def test_an_alias_is_resolved_as_ssh_does():
    host = Host(name="bot", address="bot-of-the-config")
    assert address_of(host, lambda host: "127.0.0.7") == "127.0.0.7"


def test_an_address_that_means_nothing_names_its_host():
    host = Host(name="bot", address="no.such.host.invalid", where="hosts.yaml:3")
    with pytest.raises(UsageError, match=r"'no.such.host.invalid' of bot ") as error:
        address_of(host, lambda host: host.address)
    assert error.value.where == "hosts.yaml:3"


def test_ipv6_is_refused():
    with pytest.raises(UsageError, match="'fd00::1' of bot is an IPv6 address") as error:
        address_of(Host(name="bot", address="fd00::1"))
    assert "IPv4" in (error.value.hint or "")


def test_the_usual_port_follows_from_the_domain():
    ports = [usual_port(domain) for domain in ("", "0", "42", "abc")]
    assert ports == [DEFAULT_PORT, 11811, 11853, 11811]
    discovery = Discovery(mode=DiscoveryMode.SERVER, server="bot1")
    (server,) = wire(discovery, HOSTS, domain="42").servers
    assert server.port == 11853
