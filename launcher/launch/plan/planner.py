"""Evaluates a launch file in virtual time; the plan records what would be started, and when.

Phase `run`: every process starts and keeps running, timers fire. Phase `exit`: each process in turn
exits once with code 0, and the consequences are evaluated. A shutdown ends phase `run` and is
ignored in phase `exit`. `Command` and functions of the launch file are really executed.
"""

from __future__ import annotations

import contextlib
import heapq
import math
import signal
import sys
from collections import deque
from collections.abc import Iterable
from pathlib import Path

from launcher.base import text_file
from launcher.base.errors import LaunchFileError
from launcher.base.model import events as model
from launcher.base.model.record import replace
from launcher.base.model.spec import ParameterSource, ProcessSpec
from launcher.base.text import typed_error
from launcher.language.compat import vocabulary
from launcher.language.events.launch import TimerEvent
from launcher.language.interpreter.interpreter import Interpreter
from launcher.launch.needed_release import FIRST
from launcher.launch.plan.plan import Occasion, Plan, PlanError, PlannedProcess, Stamp
from launcher.packages import reading_once

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.description import LaunchDescription
    from launcher.language.events.launch import Shutdown
    from launcher.language.interpreter.trace import Trace

HORIZON_S = 3600.0  # end of virtual time: respawns and timers may repeat endlessly
_FATAL_SIGNALS = {signal.SIGINT, signal.SIGTERM, signal.SIGKILL, signal.SIGQUIT, signal.SIGHUP}
USER_LOGGER = "launch.user"


def make_plan(
    path: str,
    arguments: Iterable[tuple[str, str]],
    *,
    with_scopes: bool = False,
    debug: bool = False,
    target: str | None = None,
) -> Plan:
    """The plan of a launch file of any kind; faults of the file are in `plan.error`.

    `with_scopes`: as rules of hosts need it, with what is around each process; `debug`: with
    messages of level DEBUG; `target`: as this distribution of ROS 2 does it.
    """
    plan = Plan(path)
    arguments = list(arguments)
    words = [path, *(f"{name}:={value}" for name, value in arguments)]
    # Launch files print; standard output belongs to the plan.
    stderr = contextlib.redirect_stdout(sys.stderr)
    with vocabulary(words) as session, stderr, reading_once():
        session.is_debug, session.target = debug, target
        session.watched = frozenset(FIRST)
        description = _load(plan)
        if description is not None:
            _evaluate(plan, description, arguments, with_scopes)
        plan.reads_arguments = session.reads_arguments
        plan.uses, plan.distribution = tuple(session.uses), session.distribution
    return plan


def _load(plan: Plan) -> LaunchDescription | None:
    from launcher.language import frontends

    try:
        return frontends.load(plan.path)
    except LaunchFileError as fault:
        plan.arguments_error = fault.message
        plan.error = plan_error(fault, getattr(fault, "stage", "load"), "run")
        return None


def _evaluate(
    plan: Plan,
    description: LaunchDescription,
    arguments: Iterable[tuple[str, str]],
    with_scopes: bool,
) -> None:
    simulation = _VirtualTime(plan)
    interpreter = Interpreter(
        description,
        path=plan.path,
        arguments=arguments,
        answer=simulation.answer,
    )
    if with_scopes:
        interpreter.note_scopes()
    plan.environment = interpreter.environment
    plan.description = description
    plan.context = interpreter.context
    simulation.run(interpreter, description)
    plan.warnings = tuple(interpreter.warnings)
    plan.empty_run = interpreter.empty_run
    plan.names_read = frozenset(interpreter.host.names_read)
    if interpreter.host.scopes is not None:
        plan.switched_off = tuple(interpreter.host.scopes.off)
        plan.is_off_complete = interpreter.host.scopes.is_off_complete


def plan_error(fault: LaunchFileError, stage: str, phase: str) -> PlanError:
    """The error as the plan reports it."""
    cause = fault.__cause__ or fault
    kind = getattr(cause, "ros_type", None) or type(cause).__name__
    return PlanError(kind=kind, message=str(cause), stage=stage, phase=phase, fault=fault)


class _VirtualTime:
    """Simulates time and processes; answers each effect at once."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._interpreter: Interpreter
        self._trace: Trace
        self._now_s = 0.0
        self._phase = "run"
        self._cause: int | None = None
        self._exit_s = 0.0  # of the cause
        self._occasion: Occasion | None = None  # of what is being visited
        self._event: Any = None  # from which it is known
        self._timers: list[tuple[float, int, model.Event]] = []
        self._cancelled: set[int] = set()
        self._outliving: set[int] = set()  # timers that a shutdown waits for
        self._sequence = 0
        self._running: dict[int, int] = {}  # process_id -> index in the plan
        self._to_exit: deque[int] = deque()

    # ---- time

    def run(self, interpreter: Interpreter, description: LaunchDescription) -> None:
        """Phase run, then phase exit; closes the interpreter."""
        from launcher.language.interpreter.trace import (
            Trace,  # a run, whose plan is a record, has none
        )

        self._interpreter = interpreter
        interpreter.host.shutdown_filter = self._shutdown
        self._trace = Trace(interpreter.context, lambda: self._stamp)
        interpreter.host.trace = self._trace
        self._plan.visits = self._trace.roots
        try:
            interpreter.begin()
            self._run_timers()
            self._plan.declared = dict(interpreter.host.declared_values)
            self._run_exits()
            interpreter.host.judge_parameter_files(lambda: False)
        finally:
            interpreter.close()
        self._list_arguments(description)  # those of files that were not loaded, too
        if interpreter.failure is not None:
            self._plan.error = plan_error(interpreter.failure, "run", self._phase)

    def _list_arguments(self, description: LaunchDescription) -> None:
        try:
            self._plan.arguments = list(description.get_launch_arguments())
        except Exception as error:
            self._plan.arguments_error = typed_error(error)

    @property
    def _continues(self) -> bool:
        return self._interpreter.failure is None and self._phase != "shutdown"

    def _run_timers(self) -> None:
        while self._interpreter.failure is None and self._next_time_s() <= HORIZON_S:
            self._now_s = self._next_time_s()
            due: list[model.Event] = []
            while self._next_time_s() == self._now_s:
                due.append(heapq.heappop(self._timers)[2])
            self._interpreter.handle_together(due)

    def _next_time_s(self) -> float:
        while self._timers and not self._still_comes(self._timers[0][2]):
            heapq.heappop(self._timers)
        return self._timers[0][0] if self._timers else math.inf

    def _still_comes(self, event: model.Event) -> bool:
        timer_id = getattr(event, "timer_id", None)
        if self._phase == "shutdown" and timer_id not in self._outliving:
            return False
        return timer_id not in self._cancelled

    def _run_exits(self) -> None:
        while self._continues and self._to_exit:
            self._phase = "exit"
            process_id = self._to_exit.popleft()
            if process_id not in self._running:
                continue
            self._cause, self._exit_s = self._running[process_id], self._now_s
            exited, before = self._exit(process_id), self._plan.processes[self._cause].stamp
            self._occasion = Occasion(exited, self._now_s, self._cause, before)
            self._interpreter.handle_together([exited])
            self._run_timers()

    def _exit(self, process_id: int) -> model.ProcessExited:
        index = self._running.pop(process_id)
        process = self._plan.processes[index]
        if process.respawn and process.respawn_max_retries != 0:
            delay_s = max(0.0, process.respawn_delay or 0.0)
            started = model.ProcessStarted(process_id=process_id, pid=_pid(process_id))
            self._at(delay_s, started)
        return model.ProcessExited(
            process_id=process_id,
            pid=_pid(process_id),
            returncode=0,
            will_restart=process.respawn,
        )

    def _at(self, delay_s: float, event: model.Event) -> None:
        self._sequence += 1
        heapq.heappush(self._timers, (self._now_s + delay_s, self._sequence, event))

    # ---- effects

    @property
    def _stamp(self) -> Stamp:
        event = self._trace.event
        if event is not self._event:
            self._event, self._occasion = event, self._occasion_of(event)
        return Stamp(
            time_s=self._now_s,
            phase=self._phase,
            cause=self._cause,
            since_cause_s=None if self._cause is None else self._now_s - self._exit_s,
            occasion=self._occasion,
        )

    def _occasion_of(self, event: Any) -> Occasion | None:
        """That of what follows an event. Events of the launch file itself are no occasions."""
        emission = None if event is None else self._trace.emission_of(event)
        if emission is not None:
            before: Occasion | None = emission.stamp.occasion
            return before
        about = getattr(event, "timer_action" if isinstance(event, TimerEvent) else "action", None)
        visit = None if about is None else self._trace.visit_of(about)
        if visit is None and getattr(about, "is_lifecycle_node", False):  # of a component
            return Occasion(event, self._now_s, None, Stamp(self._now_s, self._phase, self._cause))
        if visit is None:
            return self._occasion
        if isinstance(event, TimerEvent):
            occasion: Occasion | None = visit.stamp.occasion
            return occasion
        number = visit.processes[-1] if visit.processes else None
        since = visit.stamp if number is None else self._plan.processes[number].stamp
        return Occasion(event, self._now_s, number, since)

    def _shutdown(self, event: Shutdown) -> bool:
        if self._phase == "shutdown":
            return True
        self._plan.shutdowns.append((str(event.reason), self._stamp))
        if self._phase == "exit":
            return False
        self._phase = "shutdown"
        return True

    def answer(self, effect: model.Effect) -> list[model.Event]:
        """Record the effect in the plan; returns the events that it causes immediately."""
        match effect:
            case model.StartProcess():
                return self._start(effect)
            case model.CallLater(timer_id=timer_id, delay_s=delay_s):
                self._at(delay_s, model.TimerFired(timer_id=timer_id))
                if effect.outlives_shutdown or self._phase == "shutdown":
                    self._outliving.add(timer_id)
            case model.CancelTimer(timer_id=timer_id):
                self._cancelled.add(timer_id)
            case model.LogMessage(logger=logger, text=text, sink=sink):
                if logger == USER_LOGGER and sink != "log":
                    self._plan.logs.append((text, self._stamp))
                    self._trace.logged(text)
            case model.SignalProcess(process_id=process_id, signum=signum):
                if signum in _FATAL_SIGNALS and process_id in self._running:
                    return [self._exit(process_id)]
            case model.StopProcess(process_id=process_id):
                if process_id in self._running:
                    return [self._exit(process_id)]
            case model.LoadComponent(request_id=request_id, request=load):
                self._plan.loads.append((load, self._stamp))
                return [_loaded(request_id, load)]
            case model.ChangeState(request_id=request_id, request=change):
                self._plan.lifecycle.append((change, self._stamp))
                return [model.StateChanged(request_id=request_id), *_transitions(change)]
        return []

    def _start(self, effect: model.StartProcess) -> list[model.Event]:
        action = self._interpreter.host.processes[effect.process_id].action
        respawn, delay_s, retries = action._respawn_settings()
        planned = PlannedProcess(
            spec=with_temporary_files(effect.spec),
            respawn=respawn,
            respawn_delay=delay_s,
            respawn_max_retries=retries,
            stamp=self._stamp,
        )
        index = len(self._plan.processes)
        self._trace.started(action, index)
        self._running[effect.process_id] = index
        self._to_exit.append(effect.process_id)
        self._plan.processes.append(planned)
        return [model.ProcessStarted(process_id=effect.process_id, pid=_pid(effect.process_id))]


def with_temporary_files(spec: ProcessSpec) -> ProcessSpec:
    """The spec with the content of parameter files that functions of the launch file wrote."""
    if spec.ros is None:
        return spec
    parameters = tuple(_with_content(source) for source in spec.ros.parameters)
    return replace(spec, ros=replace(spec.ros, parameters=parameters))


def _with_content(source: ParameterSource) -> ParameterSource:
    if source.file is None or source.generated is not None:
        return source
    import tempfile

    path = Path(source.file)
    if path.parent != Path(tempfile.gettempdir()):
        return source
    import yaml

    from launcher.base.model.parameter_text import read

    try:
        content = read(text_file.read(path))
    except (OSError, ValueError, yaml.YAMLError):
        return source  # the node will complain
    return replace(source, generated=content) if isinstance(content, dict) else source


def _pid(process_id: int) -> int:
    return 100_000 + process_id  # a placeholder: nothing is started


def _loaded(request_id: int, load: model.LoadRequest) -> model.ComponentLoaded:
    return model.ComponentLoaded(request_id, full_node_name=load.full_name, unique_id=1)


def _transitions(change: model.StateRequest) -> list[model.Event]:
    from launcher.base.model.lifecycle_transitions import transition_steps

    steps = transition_steps(change.transition_id)
    return [
        model.TransitionSeen(node=change.node, transition=label, start_state=start, goal_state=goal)
        for label, start, goal in steps
    ]
