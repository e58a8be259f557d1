"""Resource usage of each process of a run, read from /proc.

The sample of a process includes its whole session, of which each process has its own: shells and
their children count together, even if a shell in between has exited. A descendant with a session of
its own is not included.

Cost: two files of /proc per process and round for CPU, RSS, threads and open files, with a part of
the USS 0.4 to 0.8 of what psutil takes for the same values (`python -m benchmarks sampling`). What
its import costs a run, where these samples would be its only user, is in `launcher.posix.proc`.
The USS, for which the kernel walks all pages (0.5 ms for a node), is read of at most
`USS_PER_ROUND` processes per round, and of more only if they are new.

All at once would block the output, so each step of a round reads at most one process, and lines are
read between them. A thread reads the USS, since the kernel may take 2 ms for one.
"""

from __future__ import annotations

import _thread
import functools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.model.record import Record
from launcher.base.model.run_events import Sample
from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Generator

    Steps = Generator[float, None, dict[int, Sample]]

PIDS_PER_STEP = 50  # getsid() is quick, but is called for every process of the machine
USS_PER_ROUND = 3  # the most expensive value: the kernel walks all pages
NEW_USS_PER_ROUND = 10  # of new processes, which have no value yet
USS_AT_S = (1.0, 3.0)  # after it was first seen: it grows while the process loads libraries
USS_EVERY_S = 10.0  # later, when it seldom changes fast
USS_PAUSE_S = 0.001  # between looks whether the thread is ready
NO_GUESTS: Mapping[int, int] = {}
USS_WAIT_S = 0.2  # then the round goes on without the new values
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


class Reading(Record):
    """Resource usage of a single process; `cpu_s` is since the last reading."""

    cpu_s: float
    rss_bytes: int
    uss_bytes: int | None
    threads: int
    fds: int


def summed(root: int, readings: Sequence[Reading], elapsed_s: float) -> Sample:
    """The sample of a tree from those of its members; `elapsed_s` is 0 for its first sample."""
    uss = [reading.uss_bytes for reading in readings]
    known = [value for value in uss if value is not None]
    used_s = sum(reading.cpu_s for reading in readings)
    return Sample(
        pid=root,
        cpu_percent=100 * used_s / elapsed_s if elapsed_s > 0 else None,
        rss_bytes=sum(reading.rss_bytes for reading in readings),
        uss_bytes=sum(known) if len(known) == len(uss) else None,
        threads=sum(reading.threads for reading in readings),
        fds=sum(reading.fds for reading in readings),
        processes=len(readings),
    )


class Sampler:
    """Keeps the last CPU times of the processes, for the difference.

    Take the `steps` of a round once a second. `on_state(pid, is_suspended)` is called at the moment
    when the state of a process is read.
    """

    def __init__(self, on_state: Callable[[int, bool], None] = lambda *_: None) -> None:
        self._on_state = on_state
        self._uss = _UssReader()
        self._members: dict[int, _Member] = {}
        self._last_s: dict[int, float] = {}

    def steps(
        self,
        pids: Iterable[int],
        clock: Callable[[], float],
        guests: Mapping[int, int] = NO_GUESTS,
    ) -> Steps:
        """A sample for each running process of `pids`, in steps that read at most one process.

        Each pid must lead its session. A step yields how many seconds to wait before the next one.
        `clock` is monotonic. `guests`: leaders of other sessions, which count as those of a pid.
        Finish one round before the next.
        """
        sessions = yield from _sessions(frozenset(pids), guests)
        seen: dict[int, _Member] = {}
        read_s: dict[int, float] = {}
        for root, session in sessions.items():
            read_s[root] = now = clock()
            for pid in session:
                member = self._look(pid, now, is_late=root in self._last_s)
                if member is not None:
                    seen[pid] = member
                yield 0.0
        self._members = seen
        now = clock()
        if not self._uss.is_busy:
            self._uss.start(self._due(now), now)
        while self._uss.is_busy and clock() < now + USS_WAIT_S:
            yield USS_PAUSE_S
        self._uss.take()
        samples = {}
        for root, session in sessions.items():
            if root in seen:  # else its leader has exited
                readings = [seen[pid].reading for pid in session if pid in seen]
                elapsed_s = read_s[root] - self._last_s.get(root, read_s[root])
                samples[root] = summed(root, readings, elapsed_s)
        self._last_s = {root: read_s[root] for root in samples}
        return samples

    def _look(self, pid: int, now: float, *, is_late: bool) -> _Member | None:
        """Read a process; None if it has ended. A pid that was reused is a new one.

        The USS of members that are new in a known tree starts at 0, so that its sum stays known.
        """
        fields = proc.living_fields(pid)
        if not fields:
            return None
        self._on_state(pid, fields[proc.STATE] in proc.SUSPENDED)
        fds = _open_files(pid)
        if fds is None:
            return None  # just ended, or runs as another user
        member = self._members.get(pid)
        if member is None or member.started != fields[proc.START_TICKS]:
            member = _Member(pid, fields[proc.START_TICKS], now)
            member.uss_bytes = 0 if is_late else None
        member.update(fields, fds)
        return member

    def _due(self, now: float) -> list[_Member]:
        """The members whose USS is to be read in this round."""
        due = sorted(
            (m for m in self._members.values() if m.uss_due_s <= now), key=lambda m: m.uss_due_s
        )
        new = [m for m in due if m.is_new][:NEW_USS_PER_ROUND]
        others = [m for m in due if not m.is_new]
        return [*new, *others[: max(0, USS_PER_ROUND - len(new))]]


class _Member:
    """One process; `started`, in clock ticks since boot, and its pid identify it."""

    __slots__ = (
        "_cpu_s",
        "_fds",
        "_rss_bytes",
        "_seen_s",
        "_threads",
        "_used_s",
        "_uss_reads",
        "pid",
        "started",
        "uss_bytes",
        "uss_due_s",
    )

    def __init__(self, pid: int, started: bytes, now: float) -> None:
        self.pid = pid
        self.started = started
        self._seen_s = now
        self._uss_reads = 0
        self._cpu_s = self._used_s = 0.0
        self._rss_bytes = self._threads = self._fds = 0
        self.uss_bytes: int | None = None
        self.uss_due_s = now + USS_AT_S[0]

    def update(self, fields: Sequence[bytes], fds: int) -> None:
        """Note what /proc/PID/stat says, and the CPU time since the last call.

        A new member of a known tree was started after the last sample: all its CPU time counts.
        """
        cpu_s = (int(fields[proc.USER_TICKS]) + int(fields[proc.SYSTEM_TICKS])) / _TICKS_PER_S
        self._used_s, self._cpu_s = cpu_s - self._cpu_s, cpu_s
        self._rss_bytes = int(fields[proc.RSS_PAGES]) * _PAGE_BYTES
        self._threads, self._fds = int(fields[proc.THREADS]), fds

    @property
    def reading(self) -> Reading:
        return Reading(self._used_s, self._rss_bytes, self.uss_bytes, self._threads, self._fds)

    @property
    def is_new(self) -> bool:
        """Whether its USS is still read at the times of a new process."""
        return self._uss_reads < len(USS_AT_S)

    def plan_next(self, now: float) -> None:
        """Its USS is read now: set the time of the next reading."""
        self._uss_reads += 1
        if self.is_new:
            self.uss_due_s = max(now + 1.0, self._seen_s + USS_AT_S[self._uss_reads])
        else:
            self.uss_due_s = now + USS_EVERY_S


class _UssReader:
    """Reads the USS of processes in a thread."""

    def __init__(self) -> None:
        self.is_busy = False
        self._found: list[tuple[_Member, int]] = []

    def start(self, members: Sequence[_Member], now: float) -> None:
        if members:
            for member in members:
                member.plan_next(now)
            self.is_busy = True
            _thread.start_new_thread(self._read, (members,))

    def _read(self, members: Sequence[_Member]) -> None:
        for member in members:
            uss_bytes = proc.uss_bytes(member.pid)
            if uss_bytes is not None:  # else it has just ended, or runs as another user
                self._found.append((member, uss_bytes))
        self.is_busy = False

    def take(self) -> None:
        """Give the processes what was read."""
        while self._found:
            member, uss_bytes = self._found.pop()
            member.uss_bytes = uss_bytes


def _sessions(
    roots: frozenset[int], guests: Mapping[int, int]
) -> Generator[float, None, dict[int, list[int]]]:
    """Session leader -> all pids in its session, for those leaders that are in `roots`."""
    sessions: dict[int, list[int]] = {}
    for number, pid in enumerate(proc.pids(), 1):
        if number % PIDS_PER_STEP == 0:
            yield 0.0
        try:
            leader = os.getsid(pid)
        except OSError:
            continue  # it has just exited
        leader = guests.get(leader, leader)
        if leader in roots:
            sessions.setdefault(leader, []).append(pid)
    return sessions


def _open_files(pid: int) -> int | None:
    """The number of its descriptors; None if it has ended or runs as another user."""
    folder = f"{proc.ROOT}/{pid}/fd"
    try:
        count = os.stat(folder).st_size if _counts_files() else len(os.listdir(folder))
    except OSError:
        return None
    if not count and (tid := proc.living_thread(pid)) != pid:
        return _open_files(tid)
    return count


@functools.cache
def _counts_files() -> bool:
    """Whether the kernel (6.2) gives the number of descriptors as the size of their folder."""
    return os.stat("/proc/self/fd").st_size > 0
