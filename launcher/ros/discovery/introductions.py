"""Introduces a node that starts to those that run already, so that it hears of them at once.

A Fast DDS participant announces itself a moment before it listens (CONFORMANCE 4.12). Those that
run answer within 0.2 ms, it loses most answers, and the next ones are regular announcements, which
come every 3 s. A participant answers each new one, at the address that this one announces. So when
a participant has appeared in /proc/net/udp and had time to listen, the launcher announces one that
does not exist, with the address of the new participant, and disposes of it a moment later. The
answers go to the new participant, which then discovers everybody.

Such an announcement names no ROS node (it has no enclave), so rmw does not show it, and nothing is
sent while no node starts. Only participants on this machine that discover each other directly are
introduced: none with a discovery server or with profiles of the user.

Measured with the fleet, from the start of robot_1 to its first task, eight restarts, medians: 1.5 s
without, 0.5 s with introductions; of a warm robot, 0.35 s. Announcing more often (a profile with
`leaseAnnouncement`) needs 1 % of a processor for six nodes and a period of 0.4 s, and grows with
the square of their number.
"""

from __future__ import annotations

import contextlib
import functools
import socket

from launcher.posix.crowd import limit
from launcher.posix.ports import MAX_DOMAIN, occupied_ports
from launcher.ros.discovery import rtps
from launcher.run.part import Part
from launcher.run.processes.machine_events import ProcessState

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from launcher.posix.reactor import Timer
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

POLL_S = 0.02
PATIENCE_S = 10.0  # for the participant of a process that has started; then it may have none
# After a participant has its port. On an idle machine it listens 5 ms later; the others are for a
# busy one.
INTRODUCED_S = (0.02, 0.1, 0.3)
DISPOSED_S = 0.05
_LEASE_S = 1  # if the end of an announcement is lost
_ADDRESSES = 4  # that a participant of Fast DDS keeps of another
_ENDPOINT_SET = 1 << 1  # only the reader of announcements


class Introductions(Part):
    """Looks for participants while nodes of this run are starting."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._domains: dict[int, _Domain] = {}

    def begin(self) -> None:
        """The first processes started before this part was made."""
        for process in self.run.processes:
            if process.machine.state is ProcessState.RUNNING:
                self.started(process)

    def started(self, process: Process) -> None:
        """Expect its participant."""
        spec = process.spec
        number = None if spec.ros is None else _domain(spec.env)
        if number is None or process.host is not None:
            return
        if number not in self._domains:
            self._domains[number] = _Domain(self.run, number)
        self._domains[number].expect()

    def close(self) -> None:
        """Stop looking."""
        for domain in self._domains.values():
            domain.close()


class _Domain:
    """The participants of one domain on this machine, by their ports for announcements."""

    def __init__(self, run: Run, number: int) -> None:
        self._reactor = run.reactor
        self._number = number
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
        self._socket.setblocking(False)
        self._known: set[int] = set()
        self._expected = 0
        self._until_s = 0.0
        self._timer: Timer | None = None
        self._announced: list[tuple[bytes, Iterable[int]]] = []  # the ends, and for whom

    def expect(self) -> None:
        """One more participant is about to appear."""
        if self._timer is None:
            self._expected, self._known = 0, occupied_ports(self._number)
            self._wait()
        self._expected += 1
        self._until_s = self._reactor.now() + PATIENCE_S

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        for one in list(self._announced):
            self._dispose(one)
        self._socket.close()

    def _wait(self) -> None:
        self._timer = self._reactor.call_later(POLL_S, self._look)

    def _look(self) -> None:
        self._timer = None
        ports = occupied_ports(self._number)
        new, self._known = ports - self._known, ports
        self._expected -= len(new)
        if new and len(ports) > 1:
            for delay_s in INTRODUCED_S:
                self._reactor.call_later(delay_s, functools.partial(self._introduce, new, ports))
        if self._expected > 0 and self._reactor.now() < self._until_s:
            self._wait()

    def _introduce(self, new: Iterable[int], others: Iterable[int]) -> None:
        """Let the others answer the new ones."""
        if self._socket.fileno() < 0:
            return  # the run has ended
        for ports in _chunks(sorted(new), _ADDRESSES):
            announcement, end = introduction(ports)
            self._send(announcement, others)
            announced = (end, others)
            self._announced.append(announced)
            self._reactor.call_later(DISPOSED_S, functools.partial(self._dispose, announced))

    def _dispose(self, announced: tuple[bytes, Iterable[int]]) -> None:
        if announced in self._announced:
            self._announced.remove(announced)
            self._send(*announced)

    def _send(self, message: bytes, ports: Iterable[int]) -> None:
        for port in ports:
            with contextlib.suppress(OSError):  # it has gone, or there is no network
                self._socket.sendto(message, ("127.0.0.1", port))


def introduction(ports: Iterable[int]) -> tuple[bytes, bytes]:
    """The announcement of a participant at these ports of this machine, and that of its end."""
    prefix = rtps.new_prefix()
    locators = [rtps.locator("127.0.0.1", port) for port in ports]
    begun = rtps.announcement(prefix, 1, locators, endpoints=_ENDPOINT_SET, lease_s=_LEASE_S)
    ended = rtps.end_of_participant(prefix, 2)
    vendor = rtps.UNKNOWN_VENDOR
    return rtps.message(prefix, vendor, begun), rtps.message(prefix, vendor, ended)


def _domain(environment: Mapping[str, str]) -> int | None:
    """The domain of a node with this environment, if its participants answer announcements."""
    if limit(environment) is None or environment.get("ROS_DISCOVERY_SERVER"):
        return None
    word = environment.get("ROS_DOMAIN_ID") or "0"
    if not word.isdecimal() or len(word) > 3 or int(word) > MAX_DOMAIN:
        return None
    return int(word)


def _chunks(ports: list[int], size: int) -> Iterator[list[int]]:
    return (ports[at : at + size] for at in range(0, len(ports), size))
