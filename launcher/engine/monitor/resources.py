"""Resource usage of each process of a run, by psutil.

The sample of a process includes its whole session, of which each process has its own: shells and
their children count together, even if a shell in between has exited. A descendant with a session of
its own is not included.

Cost (50 rclpy-sized processes, 2-core machine): about 90 us per process and sample for CPU, RSS,
threads and files, and 530 us per process for the USS, of which at most `USS_PER_ROUND` are read
per round, and more only of those that are new. At 1 Hz that is about 0.7 % of a core, and a half
to two thirds of what psutil takes to read it all (limit of `benchmarks sampling`: 0.8).

All at once would block the output for 5 ms, so each step of a round reads at most one process,
and lines are read between them. A thread reads the USS, since the kernel may take 2 ms for one.
"""

from __future__ import annotations

import _thread
import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence

from launcher import proc
from launcher.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Generator

    import psutil

    Steps = Generator[float, None, dict[int, "Sample"]]

PIDS_PER_STEP = 50  # getsid() is quick, but is called for every process of the machine
# Within this time a pid in the session is the same process: the kernel does not reuse pids so
# soon. Reading the start time would take a quarter of the time of a sample.
RECENT_S = 3.0
USS_PER_ROUND = 3  # the most expensive value: the kernel walks all pages
NEW_USS_PER_ROUND = 10  # of new processes, which have no value yet
USS_AT_S = (1.0, 3.0)  # after it was first seen: it grows while the process loads libraries
USS_EVERY_S = 10.0  # later, when it seldom changes fast
USS_PAUSE_S = 0.001  # between looks whether the thread is ready
USS_WAIT_S = 0.2  # then the round goes on without the new values


class Sample(Record):
    """Resource usage of one process with its descendants.

    `cpu_percent` is of one core since the last sample (None for the first): four busy threads are
    400. `uss_bytes` is the memory that would be free if the tree exited, up to 10 s old; None until
    it is known for all processes of the first sample (later ones count after a second).
    `rss_bytes` counts shared pages once per process. `fds` are open file descriptors.
    """

    pid: int
    cpu_percent: float | None
    rss_bytes: int
    uss_bytes: int | None
    threads: int
    fds: int
    processes: int


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

    Make one after the first process has started (it imports psutil, 15 ms and 3 MB), then take the
    `steps` of a round once a second.
    """

    def __init__(self) -> None:
        import psutil  # here: the first process must not wait for it

        self._psutil = psutil
        self._uss = _UssReader()
        self._members: dict[int, _Member] = {}
        self._last_s: dict[int, float] = {}
        self._polled_s = -RECENT_S

    def steps(self, pids: Iterable[int], clock: Callable[[], float]) -> Steps:
        """A sample for each running process of `pids`, in steps that read at most one process.

        Each pid must lead its session. A step yields how many seconds to wait before the next one.
        `clock` is monotonic. Finish one round before the next.
        """
        sessions = yield from _sessions(frozenset(pids))
        now = clock()
        yield from self._keep(sessions, now, is_recent=now - self._polled_s < RECENT_S)
        self._polled_s = now
        yield from self._refresh_uss(clock)
        samples, read_s = {}, {}
        for root, session in sessions.items():
            now = clock()
            readings = yield from self._readings(root, session)
            if readings:
                samples[root] = summed(root, readings, now - self._last_s.get(root, now))
                read_s[root] = now
        self._last_s = read_s
        return samples

    def _keep(
        self, sessions: dict[int, list[int]], now: float, *, is_recent: bool
    ) -> Iterator[float]:
        """Update the members to these processes; a pid that was reused is a new one.

        The USS of members that are new in a known tree starts at 0, so that its sum stays known.
        """
        known: dict[int, _Member] = {}
        for root, session in sessions.items():
            for pid in session:
                member = self._members.get(pid)
                if member is None or not (is_recent or member.process.is_running()):
                    member = self._newcomer(pid, now, is_late=root in self._last_s)
                if member is not None:
                    known[pid] = member
                yield 0.0
        self._members = known

    def _newcomer(self, pid: int, now: float, *, is_late: bool) -> _Member | None:
        try:
            member = _Member(self._psutil.Process(pid), now)
        except self._psutil.Error:
            return None  # it has just ended
        member.uss_bytes = 0 if is_late else None
        return member

    def _refresh_uss(self, clock: Callable[[], float]) -> Iterator[float]:
        now = clock()
        if not self._uss.is_busy:
            self._uss.start(self._due(now), now)
        while self._uss.is_busy and clock() < now + USS_WAIT_S:
            yield USS_PAUSE_S
        self._uss.take()

    def _due(self, now: float) -> list[_Member]:
        """The members whose USS is to be read in this round."""
        due = sorted(
            (m for m in self._members.values() if m.uss_due_s <= now), key=lambda m: m.uss_due_s
        )
        new = [m for m in due if m.is_new][:NEW_USS_PER_ROUND]
        others = [m for m in due if not m.is_new]
        return [*new, *others[: max(0, USS_PER_ROUND - len(new))]]

    def _readings(self, root: int, session: list[int]) -> Generator[float, None, list[Reading]]:
        """The readings of a session; empty if its leader has exited."""
        readings = []
        for pid in session if root in self._members else ():
            member = self._members.get(pid)
            reading = None if member is None else self._read(member)
            if reading is not None:
                readings.append(reading)
            yield 0.0
        return readings

    def _read(self, member: _Member) -> Reading | None:
        process = member.process
        try:
            with process.oneshot():
                times = process.cpu_times()
                rss_bytes = process.memory_info().rss
                threads = process.num_threads()
                fds = process.num_fds()
        except self._psutil.Error:
            return None  # ended (or a zombie), or runs as another user
        cpu_s = times.user + times.system
        # A new member of a known tree was started after the last sample: all its CPU time counts.
        used_s, member.cpu_s = cpu_s - member.cpu_s, cpu_s
        return Reading(used_s, rss_bytes, member.uss_bytes, threads, fds)


class _Member:
    """One process; psutil identifies it by its start time."""

    def __init__(self, process: psutil.Process, now: float) -> None:
        self.process = process
        self._seen_s = now
        self._uss_reads = 0
        self.cpu_s = 0.0
        self.uss_bytes: int | None = None
        self.uss_due_s = now + USS_AT_S[0]

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
        import psutil

        for member in members:
            with contextlib.suppress(psutil.Error):  # just ended, or runs as another user
                self._found.append((member, member.process.memory_full_info().uss))
        self.is_busy = False

    def take(self) -> None:
        """Give the processes what was read."""
        while self._found:
            member, uss_bytes = self._found.pop()
            member.uss_bytes = uss_bytes


def _sessions(roots: frozenset[int]) -> Generator[float, None, dict[int, list[int]]]:
    """Session leader -> all pids in its session, for those leaders that are in `roots`."""
    sessions: dict[int, list[int]] = {}
    for number, pid in enumerate(proc.pids(), 1):
        if number % PIDS_PER_STEP == 0:
            yield 0.0
        try:
            leader = os.getsid(pid)
        except OSError:
            continue  # it has just exited
        if leader in roots:
            sessions.setdefault(leader, []).append(pid)
    return sessions
