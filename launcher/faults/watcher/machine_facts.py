"""Facts about the machine that explain faults: pressure, disk, clock, suspended processes."""

from __future__ import annotations

import contextlib
import itertools
import os
import time
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

_RESOURCES = ("cpu", "memory", "io")
_LOOKS = 20  # of one process: two seconds
_CHANGES = 3  # one suspension makes two
_MOST_FILES = 200  # that stay open
_DELAY_LOOKS = 7  # three seconds
STOPPED_STATES = "Tt"


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineSample:
    """The machine in one moment.

    `pressure`: the part of the time since the last sample in which some task waited for the
    resource, 0 to 1 (`some` of /proc/pressure; Linux 4.20); empty where the kernel does not say.
    `free_bytes` and `size_bytes` are of the file system of the logs. `clock_s` is the time of day
    minus the monotonic clock.
    """

    at_s: float
    pressure: Mapping[str, float]
    clock_s: float
    free_bytes: int | None = None
    size_bytes: int | None = None


class MachineReader:
    """Reads it again and again; `folder` is that of the logs."""

    def __init__(self, folder: str | None) -> None:
        self._folder = folder
        self._before: dict[str, int] = {}
        self._before_s = 0.0

    def sample(self, at_s: float) -> MachineSample:
        now_s, totals = time.monotonic(), _stall_totals()
        elapsed_us = (now_s - self._before_s) * 1e6
        pressure = {
            name: min(1.0, max(0.0, (total - self._before[name]) / elapsed_us))
            for name, total in totals.items()
            if name in self._before and elapsed_us > 0
        }
        self._before, self._before_s = totals, now_s
        free_bytes, size_bytes = self._room()
        return MachineSample(
            at_s=at_s,
            pressure=pressure,
            clock_s=_clock_s(),
            free_bytes=free_bytes,
            size_bytes=size_bytes,
        )

    def _room(self) -> tuple[int | None, int | None]:
        if self._folder is not None:
            with contextlib.suppress(OSError):
                found = os.statvfs(self._folder)
                return found.f_bavail * found.f_frsize, found.f_blocks * found.f_frsize
        return None, None


def _clock_s() -> float:
    """The time of day minus the monotonic clock, of a moment in which nothing interrupted this."""
    looks = []
    for _ in range(3):
        from_s, wall_s, to_s = time.monotonic(), time.time(), time.monotonic()
        looks.append((to_s - from_s, wall_s - from_s))
    return min(looks)[1]


def _stall_totals() -> dict[str, int]:
    """Microseconds since the start of the machine, by resource."""
    found = {}
    for name in _RESOURCES:
        with contextlib.suppress(OSError, ValueError), open(f"/proc/pressure/{name}") as file:
            found[name] = int(file.readline().rpartition("total=")[2])
    return found


class StopWatch:
    """How much of the last seconds processes were suspended, by pid."""

    def __init__(self) -> None:
        # Of each look that found it suspended, how often it had run until then; else None.
        self._looks: dict[int, deque[int | None]] = {}
        self._files: dict[int, int] = {}

    def look(self, pids: Iterable[int]) -> None:
        """Look at these processes, and forget others."""
        looks: dict[int, deque[int | None]] = {}
        for pid in pids:
            state = self._state(pid)
            if state:
                found = looks[pid] = self._looks.get(pid) or deque(maxlen=_LOOKS)
                found.append(_schedstat(pid)[2] if state in STOPPED_STATES else None)
        for pid in self._files.keys() - looks.keys():
            os.close(self._files.pop(pid))
        self._looks = looks

    def _state(self, pid: int) -> str:
        """As in /proc/PID/stat: `R`, `S`, `T` and so on; empty for none.

        The file stays open, since opening it takes longer than reading the first bytes.
        """
        file = self._files.get(pid)
        text = b""
        with contextlib.suppress(OSError):
            if file is None:
                file = os.open(f"/proc/{pid}/stat", os.O_RDONLY | os.O_CLOEXEC)
            try:
                text = os.pread(file, 512, 0)
            finally:
                self._keep(pid, file)
        return text.rpartition(b") ")[2][:1].decode("ascii", "replace")

    def _keep(self, pid: int, file: int) -> None:
        if pid in self._files or len(self._files) < _MOST_FILES:
            self._files[pid] = file
        else:
            os.close(file)

    def share(self, pid: int) -> float:
        """From 0 (never) to 1 (at every look)."""
        looks = self._looks.get(pid)
        return sum(one is not None for one in looks) / len(looks) if looks else 0.0

    def alternates(self, pid: int) -> bool:
        """Whether it was suspended, and let run, more than once."""
        looks = [one is not None for one in self._looks.get(pid, ())]
        return sum(a is not b for a, b in itertools.pairwise(looks)) >= _CHANGES

    def is_stopped(self, pid: int) -> bool:
        """Whether it has not run between the last five looks, half a second."""
        last = [*self._looks.get(pid, ())][-5:]
        return len(last) == 5 and last[0] is not None and len({*last}) == 1


class DelayWatch:
    """How much of the last seconds the main threads of processes waited for a processor.

    Source: the second number of /proc/PID/schedstat, nanoseconds on a run queue.
    """

    def __init__(self) -> None:
        self._looks: dict[int, deque[tuple[float, int]]] = {}

    def look(self, pids: Iterable[int]) -> None:
        """Look at these processes, and forget others."""
        now_s = time.monotonic()
        looks: dict[int, deque[tuple[float, int]]] = {}
        for pid in pids:
            found = looks[pid] = self._looks.get(pid) or deque(maxlen=_DELAY_LOOKS)
            found.append((now_s, _schedstat(pid)[1]))
        self._looks = looks

    def share(self, pid: int) -> float | None:
        """From 0 (never) to 1 (all the time); None where that is not known."""
        looks = self._looks.get(pid)
        if looks is None or len(looks) < 2:
            return None
        (from_s, before_ns), (to_s, now_ns) = looks[0], looks[-1]
        return (now_ns - before_ns) / 1e9 / max(to_s - from_s, 1e-9)


def _schedstat(pid: int) -> tuple[int, int, int]:
    """Nanoseconds that it ran and that it waited for a processor, and how often it ran.

    Of the main thread; zeros where the kernel does not say (Documentation/scheduler/sched-stats).
    """
    with contextlib.suppress(OSError, ValueError), open(f"/proc/{pid}/schedstat") as file:
        ran_ns, waited_ns, times = map(int, file.read().split())
        return ran_ns, waited_ns, times
    return 0, 0, 0
