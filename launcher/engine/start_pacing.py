"""Pacing: how fast processes may start, so that many nodes do not storm a small machine.

A process counts as starting until it has become calm: over the last look it neither ran nor
waited for a processor for more than a quarter of the time (`exertion`). One that has ended is not
starting any more, and one that works all the time is not waited for longer than `MOST_S`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from launcher.engine.machine import ProcessState
from launcher.engine.posix.proc import TreeCpuUsage
from launcher.engine.posix.reactor import Reactor, Timer
from launcher.engine.process import Process

LOOK_S = 0.1
LEAST_S = 0.3  # before that, an interpreter that waits for its disk looks calm
MOST_S = 10.0
SETTLE_S = 2.0  # where the kernel does not tell what a process has used
CALM_SHARE = 0.25


class StartPacing:
    """Hands processes to `start` in the order in which they came, when their turn has come.

    `stagger_s` is the least time from one start to the next, `most` how many may be starting at
    the same time (None: any number).
    """

    def __init__(
        self,
        reactor: Reactor,
        *,
        stagger_s: float,
        most: int | None,
        start: Callable[[Process], None],
    ) -> None:
        self._reactor = reactor
        self._stagger_s = stagger_s
        self._most = most
        self._start = start
        self._waiting: deque[Process] = deque()
        self._starting: dict[Process, _Look] = {}
        self._next_s = reactor.now()
        self._timer: Timer | None = None

    def admit(self, process: Process) -> None:
        """Start it when its turn comes, which may be now."""
        self._waiting.append(process)
        self._let_in()

    def withdraw(self, process: Process) -> bool:
        """Take it out of the queue; False if it is not in there."""
        if process not in self._waiting:
            return False
        self._waiting.remove(process)
        return True

    def _let_in(self) -> None:
        while self._waiting:
            wait_s = self._wait_s(self._reactor.now())
            if wait_s > 0:
                self._look_again_in(wait_s)
                return
            process = self._waiting.popleft()
            now = self._reactor.now()
            if self._most is not None:
                self._starting[process] = _Look(now)
            self._next_s = now + self._stagger_s
            self._start(process)  # which takes a moment, and may bring about further starts
            self._next_s = self._reactor.now() + self._stagger_s

    def _wait_s(self, now: float) -> float:
        for process, look in list(self._starting.items()):
            if look.is_over(process, now):
                del self._starting[process]
        if self._most is not None and len(self._starting) >= self._most:
            return LOOK_S
        return self._next_s - now

    def _look_again_in(self, wait_s: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._reactor.call_later(wait_s, self._let_in)


class _Look:
    """When a process started, and what it had used of the processors when last looked at."""

    def __init__(self, now: float) -> None:
        self._started_s = now
        self._looked_s = now
        self._exertion = TreeCpuUsage()

    def is_over(self, process: Process, now: float) -> bool:
        """Whether its start is over."""
        if process.machine.state is not ProcessState.RUNNING or process.child is None:
            return process.machine.state is not ProcessState.STARTING
        age_s, elapsed_s = now - self._started_s, now - self._looked_s
        if elapsed_s < LOOK_S * 0.9:
            return False
        self._looked_s = now
        used_s = self._exertion.used_s(process.child.pid)
        if used_s is None:
            return age_s >= SETTLE_S
        is_calm = age_s >= LEAST_S and used_s < CALM_SHARE * elapsed_s
        return is_calm or age_s >= MOST_S
