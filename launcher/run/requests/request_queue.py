"""The requests of users for one process, one after the other, without I/O.

A driver calls `add` with each request, and `settle` whenever the process may have changed, again
until there are no actions left. Requests that wait for the same are answered together; a stop
overtakes what would start the process. The table in docs/reference/control.md says which request
does what.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Callable

from launcher.base.model.record import Record
from launcher.run.requests.request_result import Kind, Result

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.processes.machine_events import ReportExit

Done = Callable[[Result], None]


class Purpose(enum.IntEnum):
    """What a request is for. Of requests that are carried out together, the highest counts."""

    ACT = 0  # anything else
    STOP = 1
    START = 2
    RESTART = 3
    DEBUG = 4  # a restart that others may not be part of, since it starts another command

    @property
    def starts(self) -> bool:
        """Whether the process is to run afterwards."""
        return self >= Purpose.START


class ProcessRequest:
    """A request for one process, until it is answered: `done` is called once.

    An ACT is carried out by `act(done)`, if it `is_urgent` before the requests that wait for an
    end. `is_replacement`: files of the process have changed, so the launch file is not informed of
    the exit. `asked_s` is when it came.
    """

    __slots__ = ("act", "asked_s", "done", "is_noted", "is_replacement", "is_urgent", "purpose")

    def __init__(
        self,
        purpose: Purpose,
        done: Done,
        *,
        act: Callable[[Done], None] = lambda done: None,
        is_urgent: bool = False,
        is_replacement: bool = False,
    ) -> None:
        self.purpose = purpose
        self.done = done
        self.act = act
        self.is_urgent = is_urgent
        self.is_replacement = is_replacement
        self.asked_s = 0.0
        self.is_noted = False


class ProcessPhase(enum.Enum):
    """What a process is doing, as far as requests depend on it."""

    ENDED = enum.auto()  # never started, stopped, exited, or given up
    BACKOFF = enum.auto()  # its restart is due later
    WAITING = enum.auto()  # its start waits for other processes
    QUEUED = enum.auto()  # its start waits for its turn, or for the preparation of warm starts
    STARTING = enum.auto()  # there is a process, whose program does not run yet
    RUNNING = enum.auto()
    STOPPING = enum.auto()
    STUCK = enum.auto()  # SIGKILL has not ended it


_OVER = (ProcessPhase.ENDED, ProcessPhase.BACKOFF)
_ALIVE = (ProcessPhase.RUNNING, ProcessPhase.STOPPING, ProcessPhase.STUCK)


class Situation(Record):
    """A process at one moment. `refusal` says why it cannot be started, if it cannot.

    `is_cut_off`: its host cannot be reached.
    """

    now: float
    phase: ProcessPhase
    last_end: ReportExit | None = None
    refusal: Kind | None = None
    is_cut_off: bool = False


class RequestOrder(enum.Enum):
    """What is done with the process."""

    STOP = enum.auto()
    START = enum.auto()
    SKIP_WAIT = enum.auto()
    BEGIN_AGAIN = enum.auto()  # a start that is queued, with what is to be started now


class Do(Record):
    """Do this for the requests of `step`."""

    order: RequestOrder
    step: RequestStep


class Answer(Record):
    """Answer these requests, which were carried out together in `step`."""

    requests: tuple[ProcessRequest, ...]
    kind: Kind
    step: RequestStep


class Act(Record):
    """The turn of an ACT has come; call `finish(step)` when it is done."""

    step: RequestStep


QueueAction = Do | Answer | Act


class StepPhase(enum.Enum):
    """How far a step is."""

    PENDING = enum.auto()  # not begun: dropped if those who asked have gone
    ENDING = enum.auto()  # the process is being stopped
    BEGINNING = enum.auto()  # it is being started
    ACTING = enum.auto()


class RequestStep:
    """Requests that are carried out together, and answered alike.

    `last_end` is the last exit before its present phase, `stopped_s` and `first_end` are of the
    first half of a restart, `old_pid` is that of the process that it stops.
    """

    def __init__(self, purpose: Purpose, requests: tuple[ProcessRequest, ...] = ()) -> None:
        self.purpose = purpose
        self.requests = list(requests)
        self.phase = StepPhase.PENDING
        self.last_end: ReportExit | None = None
        self.first_end: ReportExit | None = None
        self.stopped_s = 0.0
        self.old_pid: int | None = None

    def join(self, request: ProcessRequest) -> None:
        self.requests.append(request)
        self.purpose = max(self.purpose, request.purpose)

    def leave(self, request: ProcessRequest) -> None:
        self.requests.remove(request)
        if self.phase is StepPhase.PENDING and self.requests:
            self.purpose = max(one.purpose for one in self.requests)

    def enter(self, phase: StepPhase, situation: Situation) -> None:
        self.phase, self.last_end = phase, situation.last_end


class RequestQueue:
    """The first step is the one that is being carried out."""

    def __init__(self) -> None:
        self._steps: list[RequestStep] = []

    @property
    def current(self) -> RequestStep | None:
        return self._steps[0] if self._steps else None

    def holds(self, request: ProcessRequest) -> bool:
        """Whether it is not answered yet."""
        return any(request in step.requests for step in self._steps)

    # ---- what clients do

    def add(self, request: ProcessRequest, situation: Situation) -> list[QueueAction]:
        """The queue is settled."""
        request.asked_s = situation.now
        if request.purpose is Purpose.STOP:
            return self._add_stop(request)
        if request.is_urgent and situation.phase in _ALIVE:
            acts = itertools.takewhile(lambda step: step.purpose is Purpose.ACT, self._steps)
            self._steps.insert(len(list(acts)), RequestStep(Purpose.ACT, (request,)))
            return []
        last = next(
            (step for step in reversed(self._steps) if step.purpose is not Purpose.ACT), None
        )
        if request.purpose.starts and last is not None and _serves(last, request, situation.phase):
            last.join(request)
            is_queued = last.phase is StepPhase.BEGINNING and situation.phase is ProcessPhase.QUEUED
            is_again = request.purpose > Purpose.START and is_queued
            return [Do(RequestOrder.BEGIN_AGAIN, last)] if is_again else []
        self._steps.append(RequestStep(request.purpose, (request,)))
        return []

    def _add_stop(self, request: ProcessRequest) -> list[QueueAction]:
        answers: list[QueueAction] = []
        kept = []
        for step in self._steps:
            if not step.purpose.starts:
                kept.append(step)
                continue
            answers.append(Answer(tuple(step.requests), Kind.OVERTAKEN, step))
            if step.phase is StepPhase.ENDING:  # the stop that it has begun goes on
                stop = RequestStep(Purpose.STOP)
                stop.phase, stop.last_end = step.phase, step.last_end
                kept.append(stop)
        self._steps = kept
        for step in kept:
            if step.purpose is Purpose.STOP:
                step.join(request)
                return answers
        kept.append(RequestStep(Purpose.STOP, (request,)))
        return answers

    def withdraw(self, request: ProcessRequest) -> None:
        """Its client has gone: nothing is done for it any more, except what has begun."""
        for step in self._steps:
            if request in step.requests:
                step.leave(request)
                if step.phase is StepPhase.PENDING and not step.requests:
                    self._steps.remove(step)
                return

    # ---- what the process does

    def settle(self, situation: Situation) -> list[QueueAction]:
        """The next actions, of one step; none if there is nothing to do before a change."""
        step = self.current
        if step is None:
            return []
        if step.purpose is Purpose.ACT:
            is_due = step.phase is StepPhase.PENDING
            step.enter(StepPhase.ACTING, situation)
            return [Act(step)] if is_due else []
        if step.phase is StepPhase.PENDING:
            begin = self._begin_stop if step.purpose is Purpose.STOP else self._begin_start
            return begin(step, situation)
        if situation.phase is ProcessPhase.STUCK:
            return self._answer(step, Kind.STUCK)
        go_on = self._ending if step.phase is StepPhase.ENDING else self._beginning
        actions = go_on(step, situation)
        if not actions and situation.is_cut_off:
            return self._answer(step, Kind.LINK_LOST)
        return actions

    def finish(self, step: RequestStep) -> None:
        """An ACT is done."""
        self._steps.remove(step)

    def _answer(self, step: RequestStep, kind: Kind) -> list[QueueAction]:
        self._steps.remove(step)
        return [Answer(tuple(step.requests), kind, step)]

    def _begin_stop(self, step: RequestStep, situation: Situation) -> list[QueueAction]:
        match situation.phase:
            case ProcessPhase.ENDED:
                return self._answer(step, Kind.NOT_RUNNING)
            case ProcessPhase.STUCK:
                return self._answer(step, Kind.STUCK)
        step.enter(StepPhase.ENDING, situation)
        if situation.is_cut_off:
            return [Do(RequestOrder.STOP, step), *self._answer(step, Kind.STOP_WAITS)]
        if situation.phase is ProcessPhase.BACKOFF:
            return [Do(RequestOrder.STOP, step), *self._answer(step, Kind.RESTART_CANCELLED)]
        return [Do(RequestOrder.STOP, step)]

    def _begin_start(self, step: RequestStep, situation: Situation) -> list[QueueAction]:
        if situation.refusal is not None:
            return self._answer(step, situation.refusal)
        match situation.phase:
            case ProcessPhase.STUCK:
                return self._answer(step, Kind.STUCK)
            case ProcessPhase.ENDED | ProcessPhase.BACKOFF:
                return self._start(step, situation)
            case ProcessPhase.WAITING:
                step.enter(StepPhase.BEGINNING, situation)
                return [Do(RequestOrder.SKIP_WAIT, step)]
            case ProcessPhase.QUEUED if step.purpose is not Purpose.START:
                return [Do(RequestOrder.BEGIN_AGAIN, step), *self._answer(step, Kind.QUEUED)]
            case ProcessPhase.QUEUED:
                return self._answer(step, Kind.QUEUED)
            case _ if step.purpose is not Purpose.START:
                step.enter(StepPhase.ENDING, situation)
                return [Do(RequestOrder.STOP, step)]
            case ProcessPhase.RUNNING:
                return self._answer(step, Kind.ALREADY_RUNNING)
            case ProcessPhase.STARTING:
                step.enter(StepPhase.BEGINNING, situation)
        return []  # it starts when it has ended

    def _start(self, step: RequestStep, situation: Situation) -> list[QueueAction]:
        step.enter(StepPhase.BEGINNING, situation)
        return [Do(RequestOrder.START, step)]

    def _ending(self, step: RequestStep, situation: Situation) -> list[QueueAction]:
        has_ended = situation.last_end is not step.last_end
        if not has_ended and situation.phase not in _OVER:
            return []
        if step.purpose is Purpose.STOP:
            return self._answer(step, Kind.STOPPED if has_ended else Kind.START_CANCELLED)
        if has_ended:
            step.stopped_s, step.first_end = situation.now, situation.last_end
        if situation.refusal is not None:
            return self._answer(step, situation.refusal)
        if situation.phase in _OVER:
            return self._start(step, situation)
        step.enter(StepPhase.BEGINNING, situation)  # something else has started it
        return self._beginning(step, situation)

    def _beginning(self, step: RequestStep, situation: Situation) -> list[QueueAction]:
        if situation.phase is ProcessPhase.RUNNING:
            return self._answer(step, Kind.STARTED)
        if situation.phase not in _OVER:
            return []
        if situation.last_end is not step.last_end:
            return self._answer(step, Kind.START_FAILED)
        return self._answer(step, situation.refusal or Kind.START_CANCELLED)


def _serves(step: RequestStep, request: ProcessRequest, phase: ProcessPhase) -> bool:
    """Whether the process that this step starts is what the request asks for."""
    if not step.purpose.starts:
        return False
    if request.purpose is Purpose.START:
        return True
    has_begun = step.phase is StepPhase.BEGINNING and phase is ProcessPhase.STARTING
    return step.purpose is not Purpose.DEBUG and not has_begun
