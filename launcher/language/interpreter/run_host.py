"""RunHost: collects the requests of entities as effects for the driver."""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Callable, Iterable

from launcher.base.model import events as model
from launcher.base.model.record import Record, replace
from launcher.base.text import error_text
from launcher.language.events.launch import Shutdown
from launcher.language.interpreter.specs import make_spec

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.actions.process import ExecuteLocal
    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.events.base import Event
    from launcher.language.interpreter.node_names import NodeNames
    from launcher.language.interpreter.parameter_files import ParameterFiles
    from launcher.language.interpreter.scopes import Scopes
    from launcher.language.interpreter.trace import Trace

_ACTS = (model.StartProcess, model.LoadComponent, model.ChangeState)
_MAX_SKIPPED = 100  # actions that are recorded for the message about an empty run

Answer = Callable[[model.Effect], Iterable[model.Event]]


class RequestedProcess:
    """A requested process; `active` from StartProcess to its last exit."""

    __slots__ = ("action", "active")

    def __init__(self, action: ExecuteLocal) -> None:
        self.action = action
        self.active = True


class PendingTimer:
    """A requested timer; `action` is the one of the launch file that has requested it, if any."""

    __slots__ = ("action", "callback", "delay_s")

    def __init__(self, delay_s: float, callback: Callable[[], None], action: Any) -> None:
        self.delay_s = delay_s
        self.callback = callback
        self.action = action


class Quirk(Record):
    """A warning about surprising behaviour copied from ROS 2, and its place."""

    text: str
    origin: FileLine | None

    def render(self) -> str:
        """The line to print."""
        return f"warning: {f'{self.origin}: ' if self.origin else ''}{self.text}"


class RunHost:
    """Collects effects in order; the interpreter's loop runs the deferred steps.

    `answer` returns the events that an effect causes immediately, in virtual time; None in real
    time.
    """

    def __init__(self, context: LaunchContext, answer: Answer | None = None) -> None:
        self._context = context
        self._answer = answer
        self.numbered = 0  # the number of the last process
        self._next_id = 0
        self._loop: Any = None
        self.effects: list[model.Effect] = []
        self.answers: deque[model.Event] = deque()
        self.steps: deque[Callable[[], None]] = deque()
        self.processes: dict[int, RequestedProcess] = {}
        self.timers: dict[int, PendingTimer] = {}
        self.waiting: dict[int, Callable[[Any], None]] = {}
        self.lifecycle_watchers: dict[str, list[Callable[[Any], None]]] = {}
        self.generated: dict[str, Any] = {}
        self._sources: dict[str, str] = {}  # of generated files
        self._parameter_files: ParameterFiles | None = None
        self.declared_values: dict[str, str] = {}
        self.declared_arguments: dict[str, Any] = {}
        self.names_read: set[str] = set()
        self.quirks: dict[Quirk, None] = {}
        self._node_names: NodeNames | None = None
        self.skipped_actions: list[tuple[Any, dict[str, Any]]] = []
        self.has_acted = False  # a process was started, or a node loaded or changed
        self.shutdown_pending = False
        self.shutdown_reason: str | None = None  # of the first one
        self.trace: Trace | None = None
        self.scopes: Scopes | None = None  # of runs with a hosts file
        self._depth = 0
        self.shutdown_filter: Callable[[Shutdown], bool] = lambda event: True

    # ---- for entities (launcher.language.host.EntityHost)

    def accepts(self, event: Event) -> bool:
        """Queue everything but a shutdown that the driver's filter rejects."""
        if not isinstance(event, Shutdown):
            return True
        if not self.shutdown_filter(event):
            return False
        self.shutdown_pending = True
        if self.shutdown_reason is None:
            self.shutdown_reason = str(event.reason)
        return True

    def later(self, step: Callable[[], None]) -> None:
        self.steps.append(step)

    def next_process_number(self) -> int:
        self.numbered += 1
        return self.numbered

    def spawn(self, action: ExecuteLocal) -> None:
        """Start the process after the current event."""
        self.steps.append(lambda: self._start(action))

    def _start(self, action: ExecuteLocal) -> None:
        if self.shutdown_pending:
            action._completed()  # a shutdown requested in the same visit comes first
            return
        try:
            spec = make_spec(action, self._context, self.generated)
            if self.scopes is not None:
                spec = replace(spec, scopes=self.scopes.around(action))
        except Exception as error:
            # As in ROS 2, only the task of this process fails.
            from launcher.language.diagnostics.own_faults import own_fault

            error = own_fault(error, None) or error
            name = str(action.process_description.final_name)
            text = f"exception occurred while executing process: {error_text(error)}"
            self.log(name, "ERROR", text)
            action._completed()
            return
        process_id = self._new_id()
        self.processes[process_id] = RequestedProcess(action)
        if "--ros-args" in spec.argv:
            self._names_of_nodes.add_process(spec, self.processes[process_id])
        if "--params-file" in spec.argv:
            self._files_of_nodes.add_process(spec, action._origin)
        self.request(model.StartProcess(process_id=process_id, spec=spec))

    @property
    def _names_of_nodes(self) -> NodeNames:
        """Imported with the first node."""
        if self._node_names is None:
            from launcher.language.interpreter.node_names import NodeNames

            self._node_names = NodeNames(self)
        return self._node_names

    @property
    def _files_of_nodes(self) -> ParameterFiles:
        """Imported with the first parameter file."""
        if self._parameter_files is None:
            from launcher.language.interpreter.parameter_files import ParameterFiles

            self._parameter_files = ParameterFiles(self.generated, self._sources, self.warn_quirk)
        return self._parameter_files

    def judge_parameter_files(self, is_more_expected: Callable[[], bool]) -> None:
        """Warn of those that have nothing for any node, before what was requested meanwhile."""
        if self._parameter_files is not None and self._parameter_files.has_unused:
            before = len(self.effects)
            self._parameter_files.judge(is_more_expected=is_more_expected())
            self.effects = self.effects[before:] + self.effects[:before]

    def _new_id(self) -> int:
        self._next_id += 1
        return self._next_id

    def request(self, effect: model.Effect) -> None:
        """Hand an effect to the driver, and queue its immediate answers."""
        self.effects.append(effect)
        self.has_acted |= isinstance(effect, _ACTS)
        if self._answer is not None:
            self.answers.extend(self._answer(effect))

    def process_of(self, action: Any) -> int | None:
        for process_id, process in self.processes.items():
            if process.action is action and process.active:
                return process_id
        return None

    def call_later(
        self,
        delay_s: float,
        callback: Callable[[], None],
        *,
        outlives_shutdown: bool = False,
        on_ros_clock: bool = False,
        is_step: bool = False,
        action: Any = None,
    ) -> int:
        timer_id = self._new_id()
        self.timers[timer_id] = PendingTimer(delay_s, callback, action)
        self.request(model.CallLater(timer_id, delay_s, outlives_shutdown, on_ros_clock, is_step))
        return timer_id

    def cancel_call(self, timer_id: int) -> None:
        if self.timers.pop(timer_id, None) is not None:
            self.request(model.CancelTimer(timer_id=timer_id))

    def log(
        self, logger: str, level: str, text: str, *, sink: str = "", line: str | None = None
    ) -> None:
        self.request(model.LogMessage(logger=logger, level=level, text=text, sink=sink, line=line))

    def visiting(self, entity: object) -> None:
        self._depth += 1
        if self.trace is not None:
            self.trace.visiting(entity, self._depth)
        if self.scopes is not None:
            self.scopes.visiting(entity, self._depth)

    def visited(self) -> None:
        self._depth -= 1

    def skipped(self, action: Any) -> None:
        if self.numbered == 0 and len(self.skipped_actions) < _MAX_SKIPPED:
            from launcher.language.interpreter.empty_run import may_start, values_of

            if may_start(action):
                values = values_of(action.condition, self._context)
                self.skipped_actions.append((action, values))
        if self.trace is not None:
            self.trace.skipped(action)
        if self.scopes is not None:
            self.scopes.skipped(action)

    def warn_quirk(self, text: str, origin: FileLine | None) -> None:
        quirk = Quirk(text, origin)
        if quirk not in self.quirks:
            self.quirks[quirk] = None
            place = "" if origin is None else f"{origin}: "
            self.log("launch", "WARNING", place + text)

    def configuration_read(self, name: str) -> None:
        self.names_read.add(name)

    def configuration_written(self, name: str, value: object, origin: FileLine | None) -> None:
        if self.trace is not None:
            self.trace.configured(name, value, origin)

    def declared(self, argument: Any, value: str) -> None:
        self.declared_values[argument.name] = value
        self.declared_arguments[argument.name] = argument

    def remember_file(self, path: str, content: object, source: str | None = None) -> None:
        self.generated[path] = content
        if source is not None:
            self._sources[path] = source

    def uses_parameter_file(self, path: str, node: str | None, origin: FileLine | None) -> None:
        self._files_of_nodes.add_component(path, node, origin)

    def load_component(
        self,
        request: Any,
        done: Callable[[Any], None],
        origin: FileLine | None = None,
        rest: tuple[Any, ...] = (),
    ) -> None:
        self._names_of_nodes.add_component(request, origin)
        request_id = self._new_id()
        self.waiting[request_id] = done
        place = "the launch file" if origin is None else str(origin)
        self.request(model.LoadComponent(request_id, request, place, rest))

    def change_state(self, request: Any, done: Callable[[Any], None]) -> None:
        request_id = self._new_id()
        self.waiting[request_id] = done
        self.request(model.ChangeState(request_id=request_id, request=request))

    def watch_lifecycle(self, node: str, seen: Callable[[Any], None]) -> None:
        self.lifecycle_watchers.setdefault(node, []).append(seen)

    def asyncio_loop(self) -> Any:
        """The loop for coroutines of the launch file; asyncio is imported only now."""
        if self._loop is None:
            from launcher.language.interpreter.coroutines import make_loop

            self._loop = make_loop(self)
        return self._loop

    # ---- a later evaluation of the same launch file

    def rename(self, process_id: int, name: str, known_id: int | None = None) -> None:
        """The name of a process, and the id that it has in the run already."""
        process = self.processes.pop(process_id)
        self.processes[process_id if known_id is None else known_id] = process
        process.action._rename(name)

    def succeed(self, other: RunHost) -> None:
        """Let no new id be one of the other host."""
        self._next_id = other._next_id

    def drop_files(self, paths: Iterable[str]) -> None:
        """Delete these of the generated files."""
        for path in paths:
            if self.generated.pop(path, None) is not None:
                _delete(path)

    def take_files(self, other: RunHost, paths: Iterable[str]) -> None:
        """From now on these generated files are this host's."""
        for path in paths:
            if path in other.generated:
                self.generated[path] = other.generated.pop(path)

    # ---- for the interpreter

    def details_of(self, process_id: int) -> dict[str, Any]:
        """What an event about this process says of it; its pid is 0 before its first start."""
        details = self.processes[process_id].action.process_details
        return {"pid": 0, **(details or {})}

    def ended(self, process_id: int) -> None:
        """The process has exited, or could not be started, and is not restarted."""
        process = self.processes[process_id]
        process.active = False
        process.action._completed()

    def answered(self, event: Any) -> None:
        """Pass on a transition that was seen, or the answer to a request."""
        if isinstance(event, model.TransitionSeen):
            for seen in self.lifecycle_watchers.get(event.node, ()):
                seen(event)
            return
        done = self.waiting.pop(event.request_id, None)
        if done is not None:
            done(event)

    def take_effects(self) -> list[model.Effect]:
        """The effects since the last call."""
        taken, self.effects = self.effects, []
        return taken

    @property
    def is_busy(self) -> bool:
        """Whether further events are possible."""
        if self.timers or self.waiting or any(p.active for p in self.processes.values()):
            return True
        return any(not future.done() for future in self._context._completion_futures)

    def close(self) -> None:
        """Delete the generated files and end the coroutines."""
        for path in self.generated:
            _delete(path)
        if self._loop is not None:
            self._loop.shut_down()


def _delete(path: str) -> None:
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)
