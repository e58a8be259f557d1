"""The variables with which the nodes of a run discover each other, on every host.

`wire` is called once, before the launch file is evaluated; `Wiring.environment_of` then says what
each host needs. Addresses are numeric, since a name may mean another address on another host.
"""

from __future__ import annotations

import ipaddress
import os
import socket
import subprocess
from collections.abc import Callable, Collection, Mapping, Sequence

from launcher.base.errors import UsageError
from launcher.base.model.record import Record
from launcher.hosts.file.hosts_model import LOCAL, Discovery, DiscoveryMode, Host
from launcher.packages.distribution import profiles_variable

DEFAULT_PORT = 11811  # of Fast DDS's discovery server
SERVER_NAME = "discovery-server"  # of its process
BACKUP_NAME = "discovery-backup"
SUPER_CLIENT = "ROS_SUPER_CLIENT"  # TRUE: learns the whole graph from a server
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PEERS = "ROS_STATIC_PEERS"
SERVERS = "ROS_DISCOVERY_SERVER"
_LOOPBACK = "127.0.0.1"
_PORTS = 100  # that are tried
# A server that starts again sooner may miss nodes of the last one, which drop that after 20 s.
RESTART_DELAY_S = 21.0
MAX_WITH_PEERS = 32  # participants of a host that those of other hosts find
# Lets more than 101 processes of a domain on one machine have ports.
MANY_PARTICIPANTS = os.path.join(os.path.dirname(__file__), "many_participants.xml")
_OWN_PROFILES = (PROFILES, "FASTDDS_DEFAULT_PROFILES_FILE")
_OWN_FILES = ("DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml")
# Every mode sets all of them; an empty one is as one that is not set.
_NEUTRAL = {RANGE: "SUBNET", PEERS: "", SERVERS: "", SUPER_CLIENT: "", "ROS_LOCALHOST_ONLY": ""}
# With SUBNET, Fast DDS announces itself only to the first 4 participants of each peer, with
# LOCALHOST to the first MAX_WITH_PEERS, and with SYSTEM_DEFAULT to none.
_OF_PEERS = {**_NEUTRAL, RANGE: "LOCALHOST"}


class DiscoveryServer(Record):
    """A discovery server that the run starts; `host` is a name of the hosts file, or LOCAL.

    `arguments` are those of `launcher.hosts.discovery_server`.
    """

    name: str
    host: str
    index: int
    port: int
    listen: str

    @property
    def arguments(self) -> tuple[str, ...]:
        return (str(self.index), self.listen, str(self.port))


class Wiring(Record):
    """Who is reached where.

    `addresses` are those of the hosts by name, `own` the address of this machine as each host sees
    it.
    """

    mode: DiscoveryMode | None = None
    addresses: Mapping[str, str] = {}
    own: Mapping[str, str] = {}
    servers: tuple[DiscoveryServer, ...] = ()

    def environment_of(self, host: str = LOCAL) -> dict[str, str]:
        """The variables for nodes on this host; empty without a mode."""
        match self.mode:
            case None:
                return {}
            case DiscoveryMode.MULTICAST:
                return dict(_NEUTRAL)
            case DiscoveryMode.PEERS:
                return {**_OF_PEERS, PEERS: ";".join(self._peers_of(host))}
            case DiscoveryMode.SERVER:
                found = (f"{self._seen(one.host, host)}:{one.port}" for one in self.servers)
                return {**_NEUTRAL, SERVERS: ";".join(found)}

    def profile(self, given: Mapping[str, str]) -> dict[str, str]:
        """The variable for nodes here that have a server, unless there are profiles of users."""
        has_own = any(given.get(name) for name in _OWN_PROFILES)
        if self.mode is not DiscoveryMode.SERVER or has_own or any(map(os.path.exists, _OWN_FILES)):
            return {}
        return {profiles_variable(given): MANY_PARTICIPANTS}

    def graph_environment(self) -> dict[str, str]:
        """The variables for programs here that read the whole graph."""
        if self.mode is not DiscoveryMode.SERVER:
            return self.environment_of()
        return {**self.environment_of(), SUPER_CLIENT: "TRUE"}

    def _peers_of(self, host: str) -> list[str]:
        """Without the host itself, and each once: hosts may share an address."""
        others = [self._seen(name, host) for name in (LOCAL, *self.addresses) if name != host]
        return list(dict.fromkeys(others))

    def _seen(self, name: str, host: str) -> str:
        """The address of the host `name` as `host` sees it."""
        if name != LOCAL:
            return self.addresses[name]
        return _LOOPBACK if host == LOCAL else self.own[host]


def wire(
    discovery: Discovery,
    hosts: Sequence[Host] = (),
    known: Collection[str] = (),
    *,
    domain: str = "",
    without: dict[str, UsageError] | None = None,
) -> Wiring:
    """Find the addresses that the mode needs. UsageError if there is none.

    `hosts` are those of the run; a server on others that are `known` is left out. `domain` is
    ROS_DOMAIN_ID: runs on different domains shall have different servers. With a dictionary
    `without`, a host that has no address and no server is left out, and named there with the error.
    """
    if discovery.mode is None:
        return Wiring()
    if discovery.mode is DiscoveryMode.MULTICAST:
        return Wiring(mode=discovery.mode)
    addresses, own = _addresses(discovery, hosts, without)
    return Wiring(
        mode=discovery.mode,
        addresses=addresses,
        own=own,
        servers=_servers(discovery, addresses, known, usual_port(domain))
        if discovery.mode is DiscoveryMode.SERVER
        else (),
    )


def _addresses(
    discovery: Discovery, hosts: Sequence[Host], without: dict[str, UsageError] | None
) -> tuple[dict[str, str], dict[str, str]]:
    """(the address of each host, that of this machine on the way to it)."""
    addresses, own = {}, {}
    for host in hosts:
        try:
            address = address_of(host)
            addresses[host.name], own[host.name] = address, own_address(address)
        except UsageError as error:
            if without is None or host.name in (discovery.server, discovery.backup):
                raise
            addresses.pop(host.name, None)
            without[host.name] = error
    return addresses, own


def _servers(
    discovery: Discovery, addresses: Mapping[str, str], known: Collection[str], usual: int
) -> tuple[DiscoveryServer, ...]:
    names = {SERVER_NAME: discovery.server, BACKUP_NAME: discovery.backup}
    wanted = [(name, host) for name, host in names.items() if host is not None]
    found: list[DiscoveryServer] = []
    for index, (name, host) in enumerate(wanted):
        if host != LOCAL and host not in addresses and host in known:
            continue
        if host != LOCAL and host not in addresses:
            known = ", ".join([LOCAL, *addresses])
            raise UsageError(
                f"unknown host '{host}' of a discovery server",
                hint=f"hosts of the run: {known}",
                where=discovery.where or None,
            )
        port = _port(discovery, usual, host)
        # Of a run on this machine only, no other machine shall reach it.
        listen = "0.0.0.0" if addresses else _LOOPBACK
        found.append(DiscoveryServer(name=name, host=host, index=index, port=port, listen=listen))
    return tuple(found)


def usual_port(domain: str) -> int:
    """A discovery server does not separate domains; its port does."""
    return DEFAULT_PORT + (int(domain) if domain.isdecimal() and len(domain) < 4 else 0)


def _port(discovery: Discovery, usual: int, host: str) -> int:
    wished = discovery.port or usual
    if host != LOCAL or discovery.port is not None:
        if host == LOCAL and not _is_free(wished):
            raise UsageError(
                f"port {wished} for the discovery server is in use on this machine",
                hint="another run may have a server there; use another `port`, or none",
            )
        return wished
    for port in range(wished, wished + _PORTS):
        if _is_free(port):
            return port
    raise UsageError(
        f"no port from {wished} to {wished + _PORTS - 1} is free for the discovery server",
        hint="set `port` in `discovery:` of the hosts file",
    )


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True


def address_of(host: Host, ssh_name: Callable[[Host], str] | None = None) -> str:
    """The IPv4 address of a host, as this machine resolves its name; UsageError."""
    name = host.address
    if not _is_numeric(name):
        name = (ssh_name or ssh_host_name)(host)
    try:
        found = socket.getaddrinfo(name, None, socket.AF_INET, socket.SOCK_DGRAM)
    except OSError as error:
        is_six = _is_numeric(name) and ":" in name
        reason = "is an IPv6 address" if is_six else f"cannot be resolved: {error.strerror}"
        raise UsageError(
            f"the address '{host.address}' of {host.name} {reason}",
            hint="discovery needs an IPv4 address: Fast DDS's usual transports are UDPv4 and "
            "shared memory",
            where=host.where or None,
        ) from None
    return str(found[0][4][0])


def ssh_host_name(host: Host) -> str:
    """The name behind an alias of the user's configuration of ssh."""
    try:
        answer = subprocess.run(
            ["ssh", "-G", "--", host.address],
            capture_output=True,
            text=True,
            timeout=10,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return host.address
    settings = dict(line.partition(" ")[::2] for line in answer.stdout.splitlines())
    return settings.get("hostname", host.address)


def own_address(address: str) -> str:
    """The address of this machine on the way to that one; UsageError if there is no way."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((address, DEFAULT_PORT))  # sends nothing
        except OSError as error:
            raise UsageError(
                f"no way to {address}: {error.strerror}", hint="see: ip route get " + address
            ) from None
        return str(probe.getsockname()[0])


def _is_numeric(word: str) -> bool:
    try:
        ipaddress.ip_address(word)
    except ValueError:
        return False
    return True
