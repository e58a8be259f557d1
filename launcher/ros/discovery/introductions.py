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

In a crowd the answers of all others fill the socket of a new one, which therefore gets a larger
buffer (`receive_buffers`).

Measured with the fleet, from the start of robot_1 to its first task, medians: 1.5 s without, 0.4 s
with introductions; of a warm robot 0.3 s. A third of the restarts take 0.33 s longer (4.12).
Announcing more often (a profile with `leaseAnnouncement`) needs 1 % of a processor for six nodes
and a period of 0.4 s, and grows with the square of their number.
"""

from __future__ import annotations

import contextlib
import functools
import socket
import time

from launcher.posix.crowd import limit
from launcher.posix.ports import MAX_DOMAIN, announcement_ports, occupied_sockets
from launcher.ros.discovery import rtps
from launcher.ros.discovery.receive_buffers import enlarge
from launcher.run.part import Part
from launcher.run.processes.machine_events import ProcessState

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from launcher.posix.reactor import Timer
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

POLL_S = 0.01
# Of a processor, for looks: the kernel writes out all UDP sockets of the machine for each, which
# takes 0.25 ms with six nodes, 0.5 with 20, and 3 with 100.
MOST_LOAD = 0.05
# Some processes have several participants, those of other programs count as well, and a hundred
# nodes that start at the same time import rclpy for a minute.
SLOW_POLL_S = 0.2
# After the last start, or the last participant of it: how long a participant is about to appear,
# and how long it may appear, if there are fewer than processes and if there are as many.
SOON_S, LATE_S, SURPLUS_S = 10.0, 60.0, 5.0
# After a participant has its port. On an idle machine it listens 2 to 5 ms later; the others are
# for a busy one.
INTRODUCED_S = (0.004, 0.02, 0.1, 0.3)
DISPOSED_S = 0.05
# Between two introductions, for each participant that answers: of many that start together several
# are introduced at once.
GAP_S = 0.004
CROWD = 8  # so many participants may fill a buffer
_LEASE_S = 1  # if the end of an announcement is lost
_ADDRESSES = 4  # that a participant of Fast DDS keeps of another
_ENDPOINT_SET = 1 << 1  # only the reader of announcements


class ParticipantIntroductions(Part):
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
        self._domains[number].expect(-1 if process.child is None else process.child.pid)

    def close(self) -> None:
        """Stop looking."""
        for domain in self._domains.values():
            domain.close()


class _Domain:
    """The participants of one domain on this machine, by their ports for announcements."""

    def __init__(self, run: Run, number: int) -> None:
        self._reactor = run.reactor
        self._number = number
        self._known: dict[int, str] = {}  # port -> inode
        self._poll_s = POLL_S
        self._expected = 0
        self._since_s = self._next_s = 0.0  # of the last news, for the next introduction
        self._pids: list[int] = []  # of those that are expected, in the order of their starts
        self._due: list[tuple[float, int]] = []  # when a port is to be introduced
        self._timer: Timer | None = None
        self._announced: list[tuple[bytes, Iterable[int]]] = []  # the ends, and for whom

    def expect(self, pid: int) -> None:
        """One more participant is about to appear, of this process or one that it starts."""
        if self._timer is None:
            self._expected, self._pids, self._known = 0, [], self._sockets()
        self._since_s = self._reactor.now()
        self._expected = max(self._expected, 0) + 1
        self._pids.append(pid)
        if self._timer is None or self._timer.when > self._since_s + self._poll_s:
            self._wait(self._poll_s)

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        for one in list(self._announced):
            self._dispose(one)

    def _wait(self, delay_s: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._reactor.call_later(delay_s, self._look)

    def _look(self) -> None:
        self._timer, now_s = None, self._reactor.now()
        before, self._known = self._known, self._sockets()
        # A restarted node has the port of its predecessor.
        new = {port for port, inode in self._known.items() if before.get(port) != inode}
        if new:
            self._expected -= len(new)
            self._since_s = now_s
            if len(self._known) >= CROWD:
                self._make_room(new)
            if len(self._known) > 1:
                self._due += [(now_s + delay_s, port) for delay_s in INTRODUCED_S for port in new]
        self._introduce_due(now_s)
        age_s, is_short = now_s - self._since_s, self._expected > 0
        if self._due or age_s < (LATE_S if is_short else SURPLUS_S):
            is_soon = self._due or (is_short and age_s < SOON_S)
            self._wait(self._poll_s if is_soon else max(self._poll_s, SLOW_POLL_S))

    def _sockets(self) -> dict[int, str]:
        begun_s = time.thread_time()
        found = occupied_sockets(self._number)
        self._poll_s = max(POLL_S, (time.thread_time() - begun_s) / MOST_LOAD)
        return found

    def _introduce_due(self, now_s: float) -> None:
        due = {port for due_s, port in self._due if due_s <= now_s}
        if due and now_s >= self._next_s:
            self._due = [one for one in self._due if one[0] > now_s]
            self._next_s = now_s + GAP_S * len(self._known)
            self._introduce(due, self._known)

    def _make_room(self, new: set[int]) -> None:
        """For what the others are about to send to these."""
        sockets = announcement_ports(self._number).items()
        inodes = {inode for inode, port in sockets if port in new}
        for pid in [*self._pids]:
            if inodes and (found := enlarge(pid, inodes)):
                self._pids.remove(pid)
                inodes -= found

    def _introduce(self, new: Iterable[int], others: Iterable[int]) -> None:
        """Let the others answer the new ones."""
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
        with (
            contextlib.suppress(OSError),  # there is no network
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender,
        ):
            sender.setblocking(False)
            for port in ports:
                with contextlib.suppress(OSError):  # it has gone
                    sender.sendto(message, ("127.0.0.1", port))


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
