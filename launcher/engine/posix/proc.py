"""What is read in /proc about processes of a run: their use of the CPU, why one is stuck."""

from __future__ import annotations

import os

from launcher import proc

_Threads = dict[str, tuple[int, int]]
_STATES = {
    "D": "uninterruptible sleep",
    "Z": "a zombie",
    "T": "stopped",
    "t": "traced",
    "R": "running",
    "S": "sleeping",
}


class TreeCpuUsage:
    """CPU usage of one process and its descendants; remembers that of the last call.

    By threads: an rclpy node has a dozen, most of them of Fast DDS, and a shell leaves the work to
    its child, so that the first thread may sleep through a busy start. About 12 us a thread.
    """

    def __init__(self) -> None:
        self._before: _Threads = {}

    def used_s(self, pid: int) -> float | None:
        """Seconds since the last call, or since it was started; None if they are not available.

        What all threads together ran, or what the busiest one ran and waited for a processor: a
        machine that is too busy to let a process run does not make it calm, while many threads
        that each wait for a moment do not make it busy.
        """
        threads = _threads(pid)
        if not threads:
            return None
        ran, most = 0, 0
        for thread, (ran_ns, waited_ns) in threads.items():
            ran_before, waited_before = self._before.get(thread, (0, 0))
            ran += ran_ns - ran_before
            most = max(most, ran_ns - ran_before + waited_ns - waited_before)
        self._before = threads
        return max(ran, most) / 1e9


def _threads(pid: int) -> _Threads:
    """Thread -> nanoseconds that it ran and waited so far, of a process and its descendants."""
    threads: _Threads = {}
    waiting = [str(pid)]
    while waiting:
        tasks = f"{waiting.pop()}/task"
        try:
            names = os.listdir(f"{proc.ROOT}/{tasks}")
        except OSError:
            continue  # it has just ended
        for name in names:
            words = proc.read(f"{tasks}/{name}", "schedstat").split()
            if len(words) == 3:
                threads[name] = int(words[0]), int(words[1])
            waiting += proc.read(f"{tasks}/{name}", "children").decode().split()
    return threads


def describe_state(pid: int) -> str:
    """`state D (uninterruptible sleep), in nfs_wait`; the place only where it can be read."""
    state = proc.state(pid)
    if not state:
        return "it has just ended"
    place = proc.read(pid, "wchan").decode("ascii", "replace").strip("\0\n 0")
    where = f", in {place}" if place else ""
    return f"state {state} ({_STATES.get(state, 'see man 5 proc')}){where}{_owner(pid)}"


def _owner(pid: int) -> str:
    """Whose it is, if that is why our signals have no effect (sudo)."""
    try:
        owner = os.stat(f"{proc.ROOT}/{pid}").st_uid
    except OSError:
        return ""
    return "" if os.geteuid() in (0, owner) else f", belongs to user {owner}, who may end it"
