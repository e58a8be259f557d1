"""Exported processes find each other as those of a run with the same hosts file."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from launcher.base.model.spec import ProcessSpec
from launcher.export.export_model import ExportedSystem
from launcher.hosts.file.hosts_model import Discovery, DiscoveryMode, Host

Export = Callable[..., ExportedSystem]
HOSTS = {
    "a": Host(name="bot1", address="10.0.0.2"),
    "b": Host(name="bot2", address="10.0.0.3", environment={"ROS_STATIC_PEERS": "10.9.9.9"}),
}


def host_of(spec: ProcessSpec) -> Host | None:
    return HOSTS.get(spec.ros.node_name or "") if spec.ros else None


def variables(exported: Export, mode: DiscoveryMode | None) -> dict[str, Mapping[str, str]]:
    discovery = Discovery(mode=mode)
    system = exported("node('a'), node('b'), node('c')", host_of=host_of, discovery=discovery)
    return {one.unit: one.environment for one in system.processes}


def test_peers_are_the_addresses_of_the_other_hosts(exported: Export):
    found = variables(exported, DiscoveryMode.PEERS)
    assert found["a"]["ROS_STATIC_PEERS"] == "10.0.0.3"
    assert found["b"]["ROS_STATIC_PEERS"] == "10.9.9.9"  # of the hosts file itself
    assert found["c"]["ROS_STATIC_PEERS"] == "10.0.0.2;10.0.0.3"


def test_multicast_is_for_the_subnet(exported: Export):
    found = variables(exported, DiscoveryMode.MULTICAST)
    assert {env["ROS_AUTOMATIC_DISCOVERY_RANGE"] for env in found.values()} == {"SUBNET"}


def test_without_a_mode_the_environment_stays(exported: Export):
    assert "ROS_STATIC_PEERS" not in variables(exported, None)["a"]


@pytest.mark.parametrize(
    ("mode", "what"),
    [(DiscoveryMode.PEERS, "discovery peers"), (DiscoveryMode.SERVER, "discovery server")],
)
def test_what_is_missing_is_told(exported: Export, mode: DiscoveryMode, what: str):
    discovery = Discovery(mode=mode, where="/home/me/hosts.yaml:7")
    system = exported("node('a'), node('c')", host_of=host_of, discovery=discovery)
    (gap,) = system.gaps
    assert (gap.what, gap.place) == (what, "hosts.yaml:7")


def test_a_name_as_address_of_a_peer_is_told(exported: Export):
    host = Host(name="bot", address="bot.local")
    discovery = Discovery(mode=DiscoveryMode.PEERS)
    system = exported("node('a')", host_of=lambda spec: host, discovery=discovery)
    assert [gap.what for gap in system.gaps] == ["address 'bot.local'"]
