"""Exertion: how much a process and what it started want of the processors, thread by thread.

An rclpy node has a dozen threads, most of them of Fast DDS, and a shell leaves the work to its
child: the first thread of the process itself may sleep through a busy start. About 12 us a thread.
"""

from __future__ import annotations

import os

READ_BYTES = 4096  # of a list of children, more than a start brings about

Threads = dict[str, tuple[int, int]]


class TreeCpuUsage:
    """One process tree; remembers what its threads had used when it was last looked at."""

    def __init__(self) -> None:
        self._before: Threads = {}

    def used_s(self, pid: int) -> float | None:
        """Seconds since the last look, or since it was started; None if the kernel does not tell.

        What all threads together ran, or what the busiest one ran and waited for a processor: a
        machine that is too busy to let a process run does not make it calm, while many threads
        that each wait for a moment do not make it busy.
        """
        threads = _threads(str(pid))
        if not threads:
            return None
        ran, most = 0, 0
        for thread, (ran_ns, waited_ns) in threads.items():
            ran_before, waited_before = self._before.get(thread, (0, 0))
            ran += ran_ns - ran_before
            most = max(most, ran_ns - ran_before + waited_ns - waited_before)
        self._before = threads
        return max(ran, most) / 1e9


def _threads(pid: str) -> Threads:
    """Thread -> nanoseconds that it ran and waited so far, of a process and its descendants."""
    threads: Threads = {}
    waiting = [pid]
    while waiting:
        folder = f"/proc/{waiting.pop()}/task"
        try:
            names = os.listdir(folder)
        except OSError:
            continue  # it has just ended
        for name in names:
            words = _read(f"{folder}/{name}/schedstat").split()
            if len(words) == 3:
                threads[name] = int(words[0]), int(words[1])
            waiting += _read(f"{folder}/{name}/children").decode().split()
    return threads


def _read(path: str) -> bytes:
    """What is there to read at once, without `open()`, which takes three times as long."""
    try:
        fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return b""
    try:
        return os.read(fd, READ_BYTES)
    except OSError:
        return b""  # it has ended in between
    finally:
        os.close(fd)


_STATES = {
    "D": "uninterruptible sleep",
    "Z": "a zombie",
    "T": "stopped",
    "t": "traced",
    "R": "running",
    "S": "sleeping",
}


def describe_state(pid: int) -> str:
    """`state D (uninterruptible sleep), in nfs_wait`; the place only where the kernel tells it."""
    state = _state(pid)
    if state is None:
        return "gone in this moment"
    named = f"state {state} ({_STATES.get(state, 'see man 5 proc')})"
    place = _place(pid)
    where = f", in {place}" if place else ""
    return f"{named}{where}{_owner(pid)}"


def _owner(pid: int) -> str:
    """Whose it is, where that is why our signals do not count (sudo)."""
    try:
        owner = os.stat(f"/proc/{pid}").st_uid
    except OSError:
        return ""
    return "" if os.geteuid() in (0, owner) else f", belongs to user {owner}, who may end it"


def _state(pid: int) -> str | None:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return None


def _place(pid: int) -> str:
    """The function of the kernel that it waits in; "" where that is a secret."""
    try:
        with open(f"/proc/{pid}/wchan", encoding="ascii", errors="replace") as file:
            return file.read().strip("\0\n 0")
    except OSError:
        return ""
