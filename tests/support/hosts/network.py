"""The network of a lab: a bridge in a separate namespace, and a namespace for each computer."""

from __future__ import annotations

import itertools
import sys
from dataclasses import dataclass

from tests.support.hosts.tool import run_tool

PREFIX = "10.77"
GATEWAY = f"{PREFIX}.0.254"
FIRST_ADDRESS = 11
OPERATOR_ADDRESS = f"{PREFIX}.0.1"

_CONNECT = """
import errno, socket, sys
with socket.socket() as one:
    one.settimeout(1)
    print(int(one.connect_ex((sys.argv[1], 9)) in (0, errno.ECONNREFUSED)))
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """A computer's link to the network; `namespace` is a name of ip-netns(8)."""

    namespace: str
    bridge: str
    name: str
    address: str
    is_bridged: bool = False

    @property
    def path(self) -> str:
        return f"/run/netns/{self.namespace}"

    @property
    def enter(self) -> tuple[str, ...]:
        """The words before a command that runs in the namespace of the bridge."""
        return ("nsenter", f"--net=/run/netns/{self.bridge}")

    def set(self, *words: object, name: str = "") -> None:
        """Change the network's end of the link as with `ip link set`."""
        run_tool("ip", "-n", self.bridge, "link", "set", name or self.name, *words)

    def is_answered(self) -> bool:
        """Whether a packet passes to the operator and back.

        The computer asks for the operator's hardware address, which also gives its own to an
        operator who is just looking for it. Closed ports answer as well.
        """
        other = GATEWAY if self.address == OPERATOR_ADDRESS else OPERATOR_ADDRESS
        enter = ("nsenter", f"--net={self.path}")
        return bool(int(run_tool(*enter, sys.executable, "-c", _CONNECT, other)))

    def split(self) -> tuple[str, str]:
        """Take the link from the bridge; a relay between the two interfaces joins them again."""
        assert self.is_bridged, f"{self.name} is not on the bridge"
        outer, inner = f"o{self.name}", f"i{self.name}"
        run_tool(*("ip", "-n", self.bridge, "link", "add", outer, "type", "veth", "peer", inner))
        self.set("nomaster")
        self.set("master", "br0", "up", name=outer)
        self.set("up", name=inner)
        return self.name, inner

    def join(self) -> None:
        """Undo `split`."""
        run_tool("ip", "-n", self.bridge, "link", "del", f"o{self.name}")
        self.set("master", "br0")


class Network:
    """Makes the namespaces; the names of all start with the name of the lab."""

    def __init__(self, lab: str) -> None:
        self._lab = lab
        self._bridge = f"{lab}.bridge"
        self._ports = itertools.count()
        self._numbers = itertools.count()  # also for threads that add hosts at the same time
        add_namespace(self._bridge)
        self._ip("link add br0 type bridge mcast_snooping 0 forward_delay 0")
        self._ip(f"addr add {GATEWAY}/24 dev br0")
        self._ip("link set br0 up")
        self._sysctl("ip_forward", 1)
        self._answer_for_others("br0")

    def add_operator(self) -> Port:
        return self._add_bridged("operator", OPERATOR_ADDRESS)

    def add(self, name: str, *, multicast: bool = True, routed: bool = False) -> Port:
        """A namespace with `eth0`, on the bridge or, if `routed`, in a separate subnet.

        Without multicast the host is in the subnet of the bridge, but behind a router, which
        passes no multicast on.
        """
        number = next(self._numbers)
        if routed:
            return self._add_routed(name, f"{PREFIX}.{number + 1}.1", f"{PREFIX}.{number + 1}.2")
        address = f"{PREFIX}.0.{FIRST_ADDRESS + number}"
        return self._add_bridged(name, address) if multicast else self._add_proxied(name, address)

    def _add_bridged(self, name: str, address: str) -> Port:
        port = self._add_port(name, address, is_bridged=True)
        port.set("master", "br0")
        _route(port, GATEWAY)
        return port

    def _add_proxied(self, name: str, address: str) -> Port:
        port = self._add_port(name, address)
        self._answer_for_others(port.name)
        self._ip(f"route add {address}/32 dev {port.name}")
        _route(port, GATEWAY)
        return port

    def _add_routed(self, name: str, gateway: str, address: str) -> Port:
        port = self._add_port(name, address)
        self._ip(f"addr add {gateway}/24 dev {port.name}")
        _route(port, gateway)
        return port

    def _add_port(self, name: str, address: str, *, is_bridged: bool = False) -> Port:
        namespace = f"{self._lab}.{name}"
        port = Port(
            namespace=namespace,
            bridge=self._bridge,
            name=f"p{next(self._ports)}",
            address=address,
            is_bridged=is_bridged,
        )
        add_namespace(namespace)
        self._ip(f"link add {port.name} type veth peer name eth0 netns {namespace}")
        run_tool("ip", "-n", namespace, "addr", "add", f"{address}/24", "dev", "eth0")
        run_tool("ip", "-n", namespace, "link", "set", "eth0", "up")
        port.set("up")
        return port

    def _answer_for_others(self, interface: str) -> None:
        self._sysctl(f"conf.{interface}.proxy_arp", 1)
        self._sysctl(f"neigh.{interface}.proxy_delay", 0)

    def _ip(self, words: str) -> None:
        run_tool("ip", "-n", self._bridge, *words.split())

    def _sysctl(self, name: str, value: int) -> None:
        path = f"/proc/sys/net/ipv4/{name.replace('.', '/')}"
        enter = ("nsenter", f"--net=/run/netns/{self._bridge}")
        run_tool(*enter, "sh", "-c", 'echo "$1" > "$2"', "sh", value, path)


def add_namespace(name: str) -> None:
    run_tool("ip", "netns", "add", name)
    run_tool("ip", "-n", name, "link", "set", "lo", "up")


def _route(port: Port, gateway: str) -> None:
    run_tool("ip", "-n", port.namespace, "route", "add", "default", "via", gateway)
