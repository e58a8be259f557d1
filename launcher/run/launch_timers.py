"""The timers of the launch file. They count from the first start of their moment.

A moment is what the interpreter requests at once: its static part, or what follows an event. In
ROS 2 a start takes a millisecond; a warm one may wait for a preparation that takes seconds.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence

from launcher.base.model.events import CallLater
from launcher.posix.reactor import Reactor, Timer
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.helpers.ros_agent import AgentTimer
    from launcher.run.processes.process_driver import ProcessDriver
    from launcher.run.ros_requests import RosRequests


class TimerBatch:
    """Timers that were requested at once, and the processes whose starts are under way.

    `since_s` is from when they count; None: that is not known yet.
    """

    def __init__(self, processes: Iterable[Process], timers: Iterable[CallLater]) -> None:
        self.since_s: float | None = None
        self.processes = [*processes]
        self.timers = [*timers]

    def cancel(self) -> None:
        """A timer that does not count yet needs nothing else than to be forgotten."""


class LaunchTimers:
    """Those of a run; `fire(timer_id)` is called when one is due.

    `simulation()` is the clock for timers on the ROS clock; None while that is wall time.
    """

    def __init__(
        self,
        reactor: Reactor,
        starts: ProcessDriver,
        fire: Callable[[int], object],
        simulation: Callable[[], RosRequests | None],
    ) -> None:
        self._reactor = reactor
        self._starts = starts
        self._fire = fire
        self._simulation = simulation
        self._timers: dict[int, Timer | AgentTimer | TimerBatch] = {}
        self._on_wall_clock: dict[int, Timer] = {}  # of these, those for the ROS clock, so far
        self._outliving: set[int] = set()
        self._moments: list[TimerBatch] = []
        self._first: TimerBatch | None = None

    def __len__(self) -> int:
        return len(self._timers)

    @property
    def elapsed_s(self) -> float:
        """Seconds since the first moment of the run, as its timers count."""
        since_s = None if self._first is None else self._first.since_s
        return 0.0 if since_s is None else self._reactor.now() - since_s

    # ---- moments

    def add(self, timers: Iterable[CallLater], processes: Sequence[Process]) -> None:
        """Timers that were requested together with the starts of processes, which were begun."""
        moment = TimerBatch(filter(self._starts.is_under_way, processes), timers)
        if self._first is None:
            self._first = moment
        elif not moment.timers:
            return
        for effect in moment.timers:
            self._timers[effect.timer_id] = moment
            if effect.outlives_shutdown:
                self._outliving.add(effect.timer_id)
            if effect.is_step:
                self._begin(effect, self._reactor.now())
        started = [one.machine.running_since for one in processes]
        times = [since_s for since_s in started if since_s is not None]
        if self._awaits_preparation(moment) or (moment.processes and not times):
            self._moments.append(moment)
        else:
            self._begin_at(moment, min(times, default=self._reactor.now()))

    def settled(self, process: Process) -> None:
        """Its start is complete, has failed, or was given up."""
        if self._starts.is_under_way(process):
            return
        for moment in [one for one in self._moments if process in one.processes]:
            moment.processes.remove(process)
            since_s = process.machine.running_since
            if self._awaits_preparation(moment) or (since_s is None and moment.processes):
                continue
            self._moments.remove(moment)
            self._begin_at(moment, self._reactor.now() if since_s is None else since_s)

    def _awaits_preparation(self, moment: TimerBatch) -> bool:
        return any(map(self._starts.awaits_preparation, moment.processes))

    def _begin_at(self, moment: TimerBatch, since_s: float) -> None:
        moment.since_s = since_s
        for effect in moment.timers:
            if self._timers.get(effect.timer_id) is moment:  # else: cancelled
                self._begin(effect, since_s)

    # ---- timers

    def _begin(self, effect: CallLater, since_s: float) -> None:
        number = effect.timer_id
        clock = self._simulation() if effect.on_ros_clock else None
        if clock is not None:
            self._timers[number] = clock.call_later(number, effect.delay_s)
            return
        due = functools.partial(self._due, number)
        timer = self._timers[number] = self._reactor.call_at(since_s + effect.delay_s, due)
        if effect.on_ros_clock:
            self._on_wall_clock[number] = timer

    def _due(self, timer_id: int) -> None:
        self.forget(timer_id)
        self._fire(timer_id)

    def forget(self, timer_id: int) -> None:
        """It has fired, or never will."""
        self._timers.pop(timer_id, None)
        self._on_wall_clock.pop(timer_id, None)

    def cancel(self, timer_id: int) -> None:
        if timer_id in self._timers:
            self._timers[timer_id].cancel()
            self.forget(timer_id)

    def cancel_all(self, *, outliving: bool) -> None:
        """Cancel them all, or but for those that outlive a shutdown."""
        for timer_id in self._timers.keys() - (set() if outliving else self._outliving):
            self.cancel(timer_id)

    def move_to(self, clock: RosRequests) -> None:
        """The ROS clock is that of a simulation from now on."""
        waiting, self._on_wall_clock = self._on_wall_clock, {}
        for timer_id, timer in waiting.items():
            timer.cancel()
            left_s = max(0.0, timer.when - self._reactor.now())
            self._timers[timer_id] = clock.call_later(timer_id, left_s)
