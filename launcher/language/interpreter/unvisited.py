"""The processes of entities that are not visited, as far as they can be known.

They are behind a false condition, or come later.

Nothing is executed but what only reads and sets launch configurations; included files are loaded,
as `--show-args` of ROS 2 does it, too.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator

from launcher.base.model.events import LoadRequest
from launcher.base.model.record import Record, replace
from launcher.base.model.spec import ProcessSpec, RosIdentity, Scope
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.actions.event_actions import OpaqueFunction, RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.actions.process import ExecuteLocal, OnProcessIO
from launcher.language.actions.timer import TimerAction
from launcher.language.description import LaunchDescription
from launcher.language.events.process import ProcessExited
from launcher.language.host import NullHost
from launcher.language.ros.composition import (
    ComposableNode,
    ComposableNodeContainer,
    LoadComposableNodes,
)
from launcher.language.ros.node_and_topic_names import resolve_namespace
from launcher.language.ros.scope import PushROSNamespace
from launcher.language.substitution import Substitution, perform, perform_substitutions
from launcher.language.substitutions.command import Command
from launcher.language.type_utils import perform_typed_substitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.configurations import Configurations
    from launcher.language.context import LaunchContext

_MAX_DEPTH = 30  # of includes: a file may include itself
_OURS = ("launch.", "launch_ros.", "launcher.")


def described_scope(entity: object) -> Scope | None:
    """The scope that a group or an include is; None for other entities."""
    if isinstance(entity, GroupAction):
        origin = entity._origin
        return None if origin is None else Scope(path=origin.path, line=origin.line)
    if isinstance(entity, IncludeLaunchDescription):
        return Scope(path=os.path.abspath(entity.launch_description_source.location))
    return None


class EventTime(Record):
    """When something comes: so long after the start, or after a process of this label has exited.

    With neither, at any time.
    """

    time_s: float | None = None
    cause: str | None = None


ANY_TIME = EventTime()


class Unvisited(Record):
    """A process as far as it is known; its command line is empty, and an empty name is unknown.

    `is_likely`: no condition around it, as far as that can be known, is false now.
    """

    spec: ProcessSpec
    moment: EventTime
    is_likely: bool = True


class Search:
    """Looks into entities without a visit.

    `is_complete` becomes False if something cannot be known, such as what a function returns;
    `loads` are the components that containers load.
    """

    def __init__(self, context: LaunchContext) -> None:
        self._context = context
        self._moment = ANY_TIME
        self._is_likely = True
        self.loads: list[LoadRequest] = []
        self.is_complete = True

    def processes(
        self, entities: Iterable[Any], scopes: tuple[Scope, ...] = (), moment: EventTime = ANY_TIME
    ) -> list[Unvisited]:
        """Those in entities that come at this moment; the `scopes` are around them."""
        with self._apart():
            self._moment = moment
            return list(self._inside(entities, scopes))

    @contextlib.contextmanager
    def among(self, configurations: Configurations | None = None) -> Iterator[None]:
        """Within, the launch configurations are copies of these, or of those around."""
        self._context._push_launch_configurations(configurations)
        try:
            yield
        finally:
            self._context._pop_launch_configurations()

    def of_event(self, handler: object, scopes: tuple[Scope, ...] = ()) -> list[Unvisited]:
        """Those that an event handler would start."""
        with self._apart():
            return list(self._of_handler(handler, scopes))

    @contextlib.contextmanager
    def _apart(self) -> Iterator[None]:
        """Within, nothing that is set reaches the run."""
        host, self._context._host = self._context._host, NullHost()
        self._context._push_locals()
        self._moment, self._is_likely = ANY_TIME, True
        try:
            # In copies: the launch file may have kept these.
            with self.among(self._context.launch_configurations):
                yield
        finally:
            self._context._pop_locals()
            self._context._host = host

    def _inside(self, entities: Iterable[Any], scopes: tuple[Scope, ...]) -> Iterator[Unvisited]:
        """What entities of one scope would start; a namespace is that of the whole group."""
        for entity in entities:
            before = self._moment, self._is_likely
            self._is_likely = self._is_likely and self._may_be_wanted(entity)
            try:
                if isinstance(entity, ExecuteLocal):
                    yield from self._of_process(entity, scopes)
                elif isinstance(entity, PushROSNamespace):
                    scopes = self._pushed(entity, scopes)
                elif isinstance(entity, SetLaunchConfiguration | DeclareLaunchArgument):
                    self._set(entity)
                else:
                    yield from self._of(entity, scopes)
            except Exception:  # whatever it says, it is not a mistake of what is not visited
                self.is_complete = False
            self._moment, self._is_likely = before

    def _may_be_wanted(self, entity: object) -> bool:
        condition = getattr(entity, "condition", None)
        if condition is None or not is_harmless(list(vars(condition).values())):
            return True
        try:
            return bool(condition.evaluate(self._context))
        except Exception:  # not known yet
            return True

    def _of(self, entity: Any, scopes: tuple[Scope, ...]) -> Iterator[Unvisited]:
        if isinstance(entity, LaunchDescription):
            yield from self._inside(entity.entities, scopes)
        elif isinstance(entity, TimerAction):
            self._moment = self._after(entity)
            with self.among():
                yield from self._inside(list(entity.actions), scopes)
        elif isinstance(entity, RegisterEventHandler):
            yield from self._of_handler(entity.event_handler, scopes)
        elif isinstance(entity, GroupAction):
            yield from self._of_group(entity, scopes)
        elif isinstance(entity, IncludeLaunchDescription):
            yield from self._of_include(entity, scopes)
        elif isinstance(entity, LoadComposableNodes):
            self._note_loads(*entity._what_and_where)
        elif isinstance(entity, OpaqueFunction):
            self.is_complete = self.is_complete and is_ours(entity._function_called)
        elif not type(entity).__module__.startswith(_OURS):
            self.is_complete = False

    def _of_handler(self, handler: object, scopes: tuple[Scope, ...]) -> Iterator[Unvisited]:
        self._moment = self._moment_of(handler)
        self.is_complete = self.is_complete and not may_do_anything(handler)
        yield from self._inside(handler_entities(handler), scopes)

    def _of_process(self, action: ExecuteLocal, scopes: tuple[Scope, ...]) -> Iterator[Unvisited]:
        found = Unvisited(self._process(action, scopes), self._moment, self._is_likely)
        yield found
        if isinstance(action, ComposableNodeContainer):
            self._note_loads(*action._what_and_where)
        on_exit = vars(action).get("_ExecuteLocal__on_exit")
        if callable(on_exit) and not isinstance(on_exit, ExecuteLocal):
            self.is_complete = False
        self._moment = EventTime(cause=found.spec.label)
        yield from self._inside(action.get_sub_entities(), scopes)

    # ---- times

    def _after(self, timer: TimerAction) -> EventTime:
        time_s = self._moment.time_s
        if time_s is None or timer._is_on_ros_clock or not is_harmless(timer.period):
            return ANY_TIME
        return EventTime(
            time_s=time_s + perform_typed_substitution(self._context, timer.period, float)
        )

    def _moment_of(self, handler: object) -> EventTime:
        target = vars(handler).get("_OnActionEventBase__action_matcher")
        event = vars(handler).get("_OnActionEventBase__target_event_cls")
        if event is ProcessExited and isinstance(target, ExecuteLocal):
            return EventTime(cause=self._label(target))
        return ANY_TIME

    def _of_group(self, group: GroupAction, scopes: tuple[Scope, ...]) -> Iterator[Unvisited]:
        scope = described_scope(group)
        inner = scopes if scope is None else (*scopes, scope)
        with self.among():
            yield from self._inside(list(group._entries_written), inner)

    def _of_include(
        self, include: IncludeLaunchDescription, scopes: tuple[Scope, ...]
    ) -> Iterator[Unvisited]:
        if len(scopes) > _MAX_DEPTH:
            return
        if not all(is_harmless(part) for pair in include.launch_arguments for part in pair):
            self.is_complete = False
            return
        source = include.launch_description_source
        if not is_harmless(source._location_parts):
            self.is_complete = False
            return
        description = source._load_early(self._context)
        path = os.path.abspath(perform_substitutions(self._context, source._location_parts))
        scope = Scope(path=path)
        self._context.extend_locals(
            {
                "current_launch_file_path": path,
                "current_launch_file_directory": os.path.dirname(path),
            }
        )
        for name, value in include.launch_arguments:
            key = perform(self._context, name)
            self._context.launch_configurations[key] = perform(self._context, value)
        inner = scopes if scope is None else (*scopes, scope)
        yield from self._inside(description.entities, inner)

    # ---- what sets names

    def _pushed(self, push: PushROSNamespace, scopes: tuple[Scope, ...]) -> tuple[Scope, ...]:
        if not is_harmless(push.namespace):
            self.is_complete = False
            return scopes
        push.execute(self._context)
        namespace = self._context.launch_configurations.peek("ros_namespace")
        groups = [number for number, scope in enumerate(scopes) if scope.line]
        if groups:
            scope = replace(scopes[groups[-1]], namespace=namespace)
            return (*scopes[: groups[-1]], scope, *scopes[groups[-1] + 1 :])
        return scopes

    def _set(self, entity: Any) -> None:
        configurations = self._context.launch_configurations
        if isinstance(entity, SetLaunchConfiguration):
            if is_harmless(entity.name) and is_harmless(entity.value):
                name = perform_substitutions(self._context, entity.name)
                configurations[name] = perform_substitutions(self._context, entity.value)
            return
        default = entity.default_value
        is_set = configurations.peek(entity.name) is not None
        if not is_set and default is not None and is_harmless(default):
            configurations[entity.name] = perform_substitutions(self._context, default)

    # ---- processes

    def _process(self, action: ExecuteLocal, scopes: tuple[Scope, ...]) -> ProcessSpec:
        given = vars(action)
        executable = self._text(given.get("_Node__node_executable"))
        label = self._label(action)
        ros = None
        if "_Node__node_executable" in given:
            own = self._text(given.get("_Node__node_namespace"))
            ros = RosIdentity(
                package=self._text(given.get("_Node__package")),
                executable=executable,
                node_name=self._text(given.get("_Node__node_name")),
                namespace=resolve_namespace(self._context, own),
            )
        return ProcessSpec(
            name=label,
            label=label,
            argv=(),
            env={},
            ros=ros,
            place="the launch file" if action._origin is None else str(action._origin),
            scopes=scopes,
        )

    def _label(self, action: ExecuteLocal) -> str:
        description = action.process_description
        if description.final_name is not None:
            return str(description._label)
        executable = self._text(vars(action).get("_Node__node_executable"))
        words = description.cmd[:1]
        program = self._text(words[0]) if executable is None and words else executable
        return os.path.basename(self._text(description.name) or program or "")

    def _note_loads(self, nodes: Iterable[ComposableNode], container: object) -> None:
        for node in nodes:
            self.loads.append(
                LoadRequest(
                    container=self._container(container),
                    package=self._text(node.package) or "",
                    plugin=self._text(node.node_plugin) or "",
                    name=self._text(node._given_name),
                    namespace=resolve_namespace(self._context, self._text(node.node_namespace)),
                )
            )

    def _container(self, container: object) -> str:
        """The full name of a container, which is an action, or given by name."""
        if not isinstance(container, ComposableNodeContainer):
            return self._text(container) or ""
        with contextlib.suppress(RuntimeError):  # it was not evaluated
            return container.node_name
        ros = self._process(container, ()).ros
        return "" if ros is None else f"{(ros.namespace or '').rstrip('/')}/{ros.node_name or ''}"

    def _text(self, given: object) -> str | None:
        """The text of substitutions; None without any, or if it cannot be known."""
        if given is None:
            return None
        if is_harmless(given):
            with contextlib.suppress(Exception):
                return str(perform(self._context, given))
        self.is_complete = False
        return None


def is_harmless(given: object) -> bool:
    """Whether performing these substitutions executes no command and no code of others."""
    if isinstance(given, Substitution):
        if isinstance(given, Command) or not type(given).__module__.startswith(_OURS):
            return False
        return all(map(is_harmless, vars(given).values()))
    if isinstance(given, (list, tuple)):
        return all(map(is_harmless, given))
    return True


# ---- event handlers


def handler_entities(handler: Any) -> list[Any]:
    """Entities of a handler that are known before it is called."""
    at_shutdown = vars(handler).get("_OnShutdown__on_shutdown")
    more = at_shutdown if isinstance(at_shutdown, list | tuple) else ()
    return [*handler.describe()[1], *more]


def may_do_anything(handler: object) -> bool:
    """Whether a handler calls code of the launch file, or of another package."""
    at_shutdown = vars(handler).get("_OnShutdown__on_shutdown")
    called = [
        getattr(handler, "_function_called", None),
        at_shutdown if callable(at_shutdown) else None,
    ]
    if isinstance(handler, OnProcessIO):
        called = list(handler._callbacks)
    if not type(handler).__module__.startswith(_OURS):
        return True
    return not all(map(is_ours, filter(None, called)))


def is_ours(function: object) -> bool:
    """Whether it is a function of the launcher itself."""
    return (getattr(function, "__module__", None) or "").startswith("launcher.")
