"""What the check of hosts has found out, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from launcher.base.model.level import Level
from launcher.base.model.record import Record
from launcher.hosts.failures import HostError
from launcher.hosts.file.hosts_model import LOCAL, Host


class HostFinding(Record):
    """What is wrong, or worth knowing; `advice` is the repair. `hosts` has one name or two."""

    check: str
    hosts: tuple[str, ...]
    level: Level
    text: str
    advice: str


class Clock(Record):
    """How far the clock of a host is ahead of this machine's, at most `uncertainty_s` off."""

    offset_s: float
    uncertainty_s: float


class Needs(Record):
    """What the plan needs on a host."""

    packages: tuple[str, ...] = ()
    executables: tuple[tuple[str, str], ...] = ()
    interfaces: tuple[str, ...] = ()
    processes: int = 0

    @property
    def count(self) -> int:
        return len(self.packages) + len(self.executables) + len(self.interfaces)


class CheckedHost(Record):
    """A host, or this machine (`host` None), and its answers.

    `reached_s` is how long the login took. `facts` are those of `probe.facts`; none with an
    `error`.
    """

    name: str
    host: Host | None
    address: str
    needs: Needs = Needs()
    user: str = ""
    reached_s: float | None = None
    facts: Mapping[str, Any] = {}
    clock: Clock | None = None
    error: HostError | None = None

    @property
    def settings(self) -> Mapping[str, str]:
        return {name: value for name, value in self.facts.get("settings", {}).items() if value}


class Arrival(Record):
    """A datagram that has arrived; `kind` is `unicast`, `multicast` or `server`."""

    kind: str
    sender: str
    receiver: str


class Survey(Record):
    """All members by name, LOCAL among them, and which datagrams arrived."""

    members: Mapping[str, CheckedHost]
    arrived: frozenset[Arrival] = frozenset()

    @property
    def reached(self) -> Sequence[CheckedHost]:
        """Those that have answered, this machine first."""
        return [one for one in self.members.values() if one.facts]

    @property
    def hosts(self) -> Iterable[CheckedHost]:
        return [one for name, one in self.members.items() if name != LOCAL]

    def lost(self, kind: str, receivers: Iterable[str] | None = None) -> list[tuple[str, str]]:
        """The pairs (sender, receiver) between which nothing of this kind arrived."""
        names = [one.name for one in self.reached]
        wanted = names if receivers is None else [name for name in receivers if name in names]
        return [
            (sender, receiver)
            for sender in names
            for receiver in wanted
            if sender != receiver
            and Arrival(kind=kind, sender=sender, receiver=receiver) not in self.arrived
        ]
