"""Interpreter: visits a launch description and processes its event queue."""

from __future__ import annotations

import itertools
import os
import signal
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.errors import LaunchFileError
from launcher.base.model import events as model
from launcher.base.text import count, error_text
from launcher.language import launch_session
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.class_tools import is_a_subclass, is_iterable
from launcher.language.configurations import ALL_NAMES, ROS_NAMES
from launcher.language.context import LaunchContext
from launcher.language.description import LaunchDescription
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.events import launch as launch_events
from launcher.language.events import process as process_events
from launcher.language.events.handlers import (
    OnIncludeLaunchDescription,
    OnShutdown,
    TargetedHandler,
)
from launcher.language.interpreter.run_host import Answer, Quirk, RunHost
from launcher.language.launch_session import replace_environment
from launcher.language.sources import LaunchDescriptionSource
from launcher.language.utilities import visit_all_entities_and_collect_futures

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


MAX_EVENTS = 1000  # handled at once; then signals and processes have their turn
_STREAMS = {
    "stdout": process_events.ProcessStdout,
    "stderr": process_events.ProcessStderr,
}


class Interpreter:
    """Walks a launch description; see the package's docstring for the use.

    `path` is the launch file (for `ThisLaunchFileDir` and messages); `environment` replaces
    `os.environ` for the run. `answer` is for a driver in virtual time (see RunHost): there the
    interpreter does not shut down an idle or failed run, and keeps the effects of a failed visit.
    `context` is that of a LaunchService, with the handlers that a run needs; the run does not end
    for want of processes while `stays()`.
    """

    def __init__(
        self,
        description: LaunchDescription,
        *,
        path: str = "<script>",
        arguments: Iterable[tuple[str, str]] | Mapping[str, str] = (),
        environment: Mapping[str, str] | None = None,
        noninteractive: bool = False,
        answer: Answer | None = None,
        context: LaunchContext | None = None,
        stays: Callable[[], bool] = lambda: False,
    ) -> None:
        self._environment_before = dict(os.environ)
        if environment is not None:
            replace_environment(environment)
        # That of the call: loading the launch file may have changed os.environ.
        self.environment = dict(
            launch_session.current().environment if environment is None else environment
        )
        self.arguments = dict(arguments)
        self._path = path
        self._description = description
        self._is_virtual = answer is not None
        self._is_of_a_script = context is not None
        self._is_asked_to_end = False  # by a user or the driver, not by the launch file
        self.failure: LaunchFileError | None = None
        self._stays = stays
        self.context = context or self._new_context(noninteractive)
        self.host = RunHost(self.context, answer)
        self.context._host = self.host

    def _new_context(self, noninteractive: bool) -> LaunchContext:
        context = LaunchContext(
            argv=[f"{name}:={value}" for name, value in self.arguments.items()],
            noninteractive=noninteractive,
        )
        context._remember_environment(self.environment)
        context.register_event_handler(OnIncludeLaunchDescription())
        context.register_event_handler(
            OnShutdown(on_shutdown=lambda event, _: self.decide_shutdown(event))
        )
        return context

    @property
    def warnings(self) -> Sequence[Quirk]:
        """Warnings about the launch file so far, each once."""
        return tuple(self.host.quirks)

    @property
    def unused_arguments(self) -> list[str]:
        """The arguments that nothing has declared or read so far."""
        used = {*self.host.declared_values, *self.host.names_read, *ROS_NAMES}
        return [] if ALL_NAMES in used else [name for name in self.arguments if name not in used]

    @property
    def may_start_more(self) -> bool:
        """Whether handlers of the launch file may start processes that are not known yet."""
        return bool(self._own_handlers)

    @property
    def _own_handlers(self) -> list[Any]:
        harmless = (OnIncludeLaunchDescription, OnShutdown, TargetedHandler)
        return [one for one in self.context._event_handlers if type(one) not in harmless]

    def intentions(self) -> list[str]:
        """What is left to be done later: `2 timers`, `OnProcessExit at t.launch.py:12`."""
        timers = [count(len(self.host.timers), "timer")] if self.host.timers else []
        return timers + [
            f"{type(handler).__name__} at {handler._origin}"
            for handler in self.context._event_handlers
            if getattr(handler, "_origin", None) is not None  # else: one of an action
        ]

    @property
    def empty_run(self) -> str | None:
        """The message that no process was started, and why; None if one was, or after a fault."""
        if self.host.has_acted or self.failure is not None:
            return None
        from launcher.language.interpreter.empty_run import message

        auxiliary = "would be" if self._is_virtual else "was"
        return message(self.host.skipped_actions, auxiliary, self.host.shutdown_reason)

    def stay_while(self, condition: Callable[[], bool]) -> None:
        """Do not end for want of processes while this is true."""
        self._stays = condition

    def note_scopes(self) -> None:
        """From now on give each process the groups and files around it, as rules of hosts need."""
        from launcher.language.interpreter.scopes import Scopes

        self.host.scopes = Scopes(self.context)

    # ---- the driver's side

    def start(self) -> list[model.Effect]:
        """Visit the whole static part; the effects of it, in order.

        Raises LaunchFileError; what was collected before the fault is dropped.
        """
        self.begin()
        if self.failure is not None:
            raise self.failure
        return self.take_effects()

    def resume(self) -> list[model.Effect]:
        """Instead of `start`, with the context of a LaunchService: what waits in its queue."""
        self._take_messages()
        return self.handle_together([])

    def _take_messages(self) -> None:
        current = launch_session.current()
        current.sink = self.host.log
        for message, options in current.pending:
            self.host.log(*message, **options)
        current.pending.clear()
        current.warning_sink = self.host.warn_quirk
        for warning in current.pending_warnings:
            self.host.warn_quirk(*warning)
        current.pending_warnings.clear()

    def begin(self) -> None:
        """Like `start`, but keeps the effects before a fault: see `failure`."""
        self._take_messages()
        source = LaunchDescriptionSource(self._description, self._path)
        include = IncludeLaunchDescription(source, launch_arguments=self.arguments.items())
        include._origin = None  # from the command line
        event = launch_events.IncludeLaunchDescription(LaunchDescription([include]))
        self.context.emit_event_sync(event)
        try:
            self._drain()
            self._judge_parameter_files()
        except (Exception, SystemExit) as error:
            self.failure = self._explained(error)
            if self._is_virtual:
                self._run_steps()

    def take_effects(self) -> list[model.Effect]:
        """The effects since the last call."""
        return self.host.take_effects()

    def handle(self, event: model.Event) -> list[model.Effect]:
        """Process an event of the driver; returns the effects, in order."""
        return self.handle_together([event])

    def handle_together(self, events: Iterable[model.Event]) -> list[model.Effect]:
        """Like `handle`, for events of the same moment: all are queued before any is handled."""
        try:
            for event in events:
                self._accept(event)
            self._drain(None if self._is_virtual else MAX_EVENTS)
            self._judge_parameter_files()
        except (Exception, SystemExit) as error:
            self._fail(error)
        return self.take_effects()

    def watches_output(self, process_id: int) -> bool:
        """Whether a handler of the launch file matches the output of this process."""
        handlers = self.context._event_handlers.of(process_events.ProcessStdout)
        if process_id not in self.host.processes:
            return False
        if not handlers:
            return False  # as in most launch files
        probe = process_events.ProcessStdout(text=b"", **self.host.details_of(process_id))
        return any(handler.matches(probe) for handler in handlers)

    def succeed(self, other: Interpreter) -> None:
        """This one has the run of the other, and restores what that would have restored."""
        self._environment_before = other._environment_before
        self._stays = other._stays

    def close(self) -> None:
        """Delete generated files and restore `os.environ`; idempotent."""
        launch_session.current().sink = launch_session.current().warning_sink = None
        self.host.close()
        replace_environment(self._environment_before)

    # ---- events of the driver become events of the language

    def _accept(self, event: model.Event) -> None:
        match event:
            case model.TimerFired(timer_id=timer_id):
                timer = self.host.timers.pop(timer_id, None)
                if timer is not None:
                    timer.callback()
            case model.TimerLost(timer_id=timer_id, reason=reason):
                if self.host.timers.pop(timer_id, None) is not None:
                    self.host.log("launch", "ERROR", f"a timer never fires: {reason}")
            case model.ProcessStarted(process_id=process_id, pid=pid):
                process = self.host.processes[process_id]
                process.active = True  # again, if the user started an exited process
                details = process.action._started(pid)
                self.context.emit_event_sync(process_events.ProcessStarted(**details))
            case model.ProcessExited():
                self._process_exited(event)
            case model.SpawnFailed(process_id=process_id, will_restart=will_restart):
                if not will_restart:
                    self.host.ended(process_id)
            case model.ProcessOutput(process_id=process_id, stream=stream, data=data):
                kind = _STREAMS[stream]
                self.context.emit_event_sync(kind(text=data, **self.host.details_of(process_id)))
            case model.SignalReceived(signum=signum):
                self._signal_received(signum)
            case model.Emitted(event=emitted):
                self.context.emit_event_sync(emitted)
            case model.ShutdownAsked(reason=reason):
                self._is_asked_to_end = True
                self._begin_shutdown(launch_events.Shutdown(reason=reason))
            case _:
                self.host.answered(event)

    def _process_exited(self, event: model.ProcessExited) -> None:
        action = self.host.processes[event.process_id].action
        action._exited(event.returncode)
        details = self.host.details_of(event.process_id)
        self.context.emit_event_sync(
            process_events.ProcessExited(returncode=event.returncode, **details)
        )
        if not event.will_restart:
            self.host.ended(event.process_id)

    def _signal_received(self, signum: int) -> None:
        self._is_asked_to_end = True
        name = signal.Signals(signum).name
        interrupted = signum == signal.SIGINT
        reason = "ctrl-c (SIGINT)" if interrupted else name
        event = launch_events.Shutdown(reason=reason, due_to_sigint=interrupted)
        self._begin_shutdown(event)

    # ---- the queue

    def _drain(self, at_most: int | None = None) -> None:
        """Empty the queue, or leave the rest to a timer: handlers may emit events for ever."""
        for handled in itertools.count():
            self._run_steps()
            if self.context._event_queue:
                if handled == at_most:
                    self.host.call_later(0.0, lambda: None, is_step=True)
                    return
                self._process(self.context._event_queue.popleft())
            elif not self._becomes_idle():
                return

    def _run_steps(self) -> None:
        while self.host.steps or self.host.answers:
            while self.host.steps:
                self.host.steps.popleft()()
            # Immediate answers come before the next event of the queue.
            while self.host.answers:
                self._accept(self.host.answers.popleft())

    def _becomes_idle(self) -> bool:
        if self._is_virtual or self.host.is_busy or self.host.shutdown_pending:
            return False
        if self.context.is_shutdown or self._stays():
            return False
        self._report_empty_run()
        self._begin_shutdown(launch_events.Shutdown(reason="idle"))
        return True

    def _report_empty_run(self) -> None:
        # A LaunchService without processes is usual in scripts.
        if self.empty_run is not None and not self._is_virtual and not self._is_of_a_script:
            level = "WARNING" if self.host.skipped_actions else "INFO"
            self.host.log("launch", level, self.empty_run)

    def _process(self, event: Any) -> None:
        for handler in self.context._event_handlers.of(event):
            if not handler.matches(event):
                continue
            self.context._push_locals()
            entities = handler.handle(event, self.context)
            many = entities if is_iterable(entities) else (entities,)
            for entity in [entity for entity in many if entity is not None]:
                if not is_a_subclass(entity, LaunchDescriptionEntity):
                    from launcher.language.diagnostics.bad_entries import from_handler

                    raise from_handler(entity, handler, event)
                visit_all_entities_and_collect_futures(entity, self.context)
            self.context._pop_locals()

    # ---- parameter files

    def _judge_parameter_files(self) -> None:
        if not self._is_virtual:
            self.host.judge_parameter_files(lambda: self._may_start_nodes)

    @property
    def _may_start_nodes(self) -> bool:
        """Whether a timer or an event may start nodes that are not known yet."""
        from launcher.language.interpreter.empty_run import handler_may_start

        return bool(self.host.timers) or any(map(handler_may_start, self._own_handlers))

    # ---- the end

    def _begin_shutdown(self, event: launch_events.Shutdown) -> None:
        if not self.context.is_shutdown:
            self.context.emit_event_sync(event)

    def decide_shutdown(self, event: Any) -> None:
        """Request the shutdown; the last handler, so that those of the launch file have run."""
        if not self.context.is_shutdown:
            self.context._set_is_shutdown(True)
            self.host.judge_parameter_files(lambda: False)
            if isinstance(event, type):  # as in EmitEvent(event=Shutdown), without ()
                event = launch_events.Shutdown()
            if event.reason != "idle" and not self._is_asked_to_end:
                self._report_empty_run()
            # The launcher's own SIGINT does not reach the processes, which have their own sessions.
            is_interrupted = event.due_to_sigint and not (
                self._is_asked_to_end or self.context.noninteractive
            )
            self.host.request(
                model.RequestShutdown(reason=str(event.reason), is_interrupted=is_interrupted)
            )
        self.host.shutdown_pending = False

    def _explained(self, error: BaseException) -> LaunchFileError:
        from launcher.language.diagnostics import faults  # most launch files have none

        return faults.explain(error, self._path, self.context)

    def _fail(self, error: BaseException) -> None:
        self.failure = self.failure or self._explained(error)
        if self._is_virtual:
            self._run_steps()
            return
        text = f"Caught exception in launch (see debug for traceback): {error_text(error)}"
        self.host.log("launch", "ERROR", text)
        if self._is_of_a_script:
            self._run_steps()  # as in ROS 2, what was visited before the error starts, and ends
        self.context._event_queue.clear()
        self.host.steps.clear()
        self._begin_shutdown(launch_events.Shutdown(reason="exception in the launch file"))
        try:
            self._drain()
        except Exception:
            # A handler fails again: stop the system without calling handlers.
            for timer_id in tuple(self.host.timers):
                self.host.cancel_call(timer_id)
            if not self.context.is_shutdown:
                self.context._set_is_shutdown(True)
                self.host.request(model.RequestShutdown(reason="exception in the launch file"))
