"""A queue of processes to start, so that many nodes do not overload a small machine.

A process counts as starting until it neither ran nor waited for a processor for more than a quarter
of the time since the last poll (`TreeCpuUsage`), until it exits, or at most for `MAX_S`.
"""

from __future__ import annotations

from collections import deque

from launcher.posix.reactor import Timer
from launcher.posix.tree_cpu_usage import TreeCpuUsage
from launcher.run.part import StartStage
from launcher.run.processes.machine_events import ProcessState
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.run import Run

POLL_S = 0.1
MIN_S = 0.3  # before that, an interpreter that waits for its disk looks idle
MAX_S = 10.0
SETTLE_S = 2.0  # if the CPU usage is not available
IDLE_SHARE = 0.25


class StartPacing(StartStage):
    """Lets processes pass in the order in which they were admitted.

    `stagger_s` is the least time from one start to the next, which for a warm one is when it is
    complete; `max_starting` how many may be starting at the same time (None: any number).
    """

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._stagger_s = run.options.stagger_s
        self._most = run.options.max_starting
        self._waiting: deque[Process] = deque()
        self._starting: dict[Process, _StartingProcess] = {}
        self._last: Process | None = None
        self._next_s = run.reactor.now()
        self._timer: Timer | None = None

    def admit(self, process: Process) -> None:
        """Queue it; it may be started at once."""
        # Its last start is over: from now on, STARTING says that it waits.
        self._starting.pop(process, None)
        if process is self._last:
            self._last = None
        self._waiting.append(process)
        self._start_next()

    def withdraw(self, process: Process) -> bool:
        """Remove it from the queue; False if it is not in there."""
        if process not in self._waiting:
            return False
        self._waiting.remove(process)
        return True

    def _start_next(self) -> None:
        while self._waiting:
            wait_s = self._wait_s(self._reactor.now())
            if wait_s > 0:
                self._poll_in(wait_s)
                return
            process = self._waiting.popleft()
            now = self._reactor.now()
            if self._most is not None:
                self._starting[process] = _StartingProcess(now)
            self._next_s = now + self._stagger_s
            self._last = process
            self.pass_on(process)  # which takes a moment, and may cause further starts
            self._next_s = self._reactor.now() + self._stagger_s

    def _wait_s(self, now: float) -> float:
        for process, look in list(self._starting.items()):
            if look.is_over(process, now):
                del self._starting[process]
        if self._most is not None and len(self._starting) >= self._most:
            return POLL_S
        return max(self._next_s - now, self._stagger_after_last_s(now))

    def _stagger_after_last_s(self, now: float) -> float:
        """How long the last start keeps back the next one, if it was not complete at once."""
        last = self._last
        if not self._stagger_s or last is None or last.host is not None:
            return 0.0
        if last.machine.state is ProcessState.STARTING:
            return min(POLL_S, self._stagger_s)
        since_s = last.machine.running_since
        return 0.0 if since_s is None else since_s + self._stagger_s - now

    def _poll_in(self, wait_s: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._reactor.call_later(wait_s, self._start_next)


class _StartingProcess:
    """A process that is starting, and its CPU usage."""

    def __init__(self, now: float) -> None:
        self._started_s = now
        self._polled_s = now
        self._usage = TreeCpuUsage()

    def is_over(self, process: Process, now: float) -> bool:
        if process.host is not None and process.host.unreachable_s is not None:
            return True  # it may take hours
        if process.machine.state is not ProcessState.RUNNING or process.child is None:
            return process.machine.state is not ProcessState.STARTING
        age_s, elapsed_s = now - self._started_s, now - self._polled_s
        if elapsed_s < POLL_S * 0.9:
            return False
        self._polled_s = now
        used_s = None if process.host is not None else self._usage.used_s(process.child.pid)
        if used_s is None:
            return age_s >= SETTLE_S
        is_idle = age_s >= MIN_S and used_s < IDLE_SHARE * elapsed_s
        return is_idle or age_s >= MAX_S
