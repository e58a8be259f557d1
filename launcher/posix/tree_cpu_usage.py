"""CPU usage of a process and its descendants."""

from __future__ import annotations

from launcher.posix import proc

_Threads = dict[int, tuple[int, int]]


class TreeCpuUsage:
    """CPU usage of one process and its descendants; remembers that of the last call.

    By threads: an rclpy node has a dozen, most of them of Fast DDS, and a shell leaves the work to
    its child, so that the first thread may sleep through a busy start. About 12 us a thread. psutil
    has ticks of 10 ms only, and no time of waiting.
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
    waiting = [pid]
    while waiting:
        pid = waiting.pop()
        for tid in proc.threads(pid):
            words = proc.read(f"{pid}/task/{tid}", "schedstat").split()
            if len(words) == 3:
                threads[tid] = int(words[0]), int(words[1])
            waiting += map(int, proc.read(f"{pid}/task/{tid}", "children").split())
    return threads
