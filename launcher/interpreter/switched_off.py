"""The processes that a false condition keeps away, as far as they can be known without a visit.

Nothing is executed but what only reads and sets launch configurations; included files are loaded,
as `--show-args` of ROS 2 does it, too.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator

from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.actions.events import OpaqueFunction, RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.actions.process import ExecuteLocal
from launcher.language.actions.timer import TimerAction
from launcher.language.description import LaunchDescription
from launcher.language.host import NullHost
from launcher.language.ros.names import resolve_namespace
from launcher.language.ros.scope import PushROSNamespace
from launcher.language.substitution import perform, perform_substitutions
from launcher.language.substitutions.command import Command
from launcher.model.record import replace
from launcher.model.spec import ProcessSpec, RosIdentity, Scope

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_DEPTH = 30  # of includes: a file may include itself
_OURS = ("launch.", "launch_ros.", "launcher.")


def described_scope(entity: Any) -> Scope | None:
    """The scope that a group or an include is; None for other entities."""
    if isinstance(entity, GroupAction):
        origin = entity._origin
        return None if origin is None else Scope(path=origin.path, line=origin.line)
    if isinstance(entity, IncludeLaunchDescription):
        return Scope(path=os.path.abspath(entity.launch_description_source.location))
    return None


class Search:
    """Looks into an entity in the context of its visit; `scopes` are around it.

    `is_complete` becomes False if something cannot be known, such as what a function returns.
    """

    def __init__(self, context: LaunchContext, scopes: tuple[Scope, ...]) -> None:
        self._context = context
        self._scopes = scopes
        self.is_complete = True

    def processes(self, entity: Any) -> list[ProcessSpec]:
        """With empty command lines. An empty name is unknown."""
        host, self._context._host = self._context._host, NullHost()  # which hears of nothing
        self._context._push_locals()
        self._context._push_launch_configurations()
        try:
            return list(self._inside([entity], self._scopes))
        finally:
            self._context._pop_launch_configurations()
            self._context._pop_locals()
            self._context._host = host

    def _inside(self, entities: Iterable[Any], scopes: tuple[Scope, ...]) -> Iterator[ProcessSpec]:
        """What entities of one scope would start; a namespace is that of the whole group."""
        for entity in entities:
            try:
                if isinstance(entity, ExecuteLocal):
                    yield self._process(entity, scopes)
                    yield from self._inside(entity.get_sub_entities(), scopes)
                elif isinstance(entity, PushROSNamespace):
                    scopes = self._pushed(entity, scopes)
                elif isinstance(entity, SetLaunchConfiguration | DeclareLaunchArgument):
                    self._set(entity)
                else:
                    yield from self._of(entity, scopes)
            except Exception:  # whatever it says, it is not a mistake of what is switched off
                self.is_complete = False

    def _of(self, entity: Any, scopes: tuple[Scope, ...]) -> Iterator[ProcessSpec]:
        if isinstance(entity, LaunchDescription):
            yield from self._inside(entity.entities, scopes)
        elif isinstance(entity, TimerAction):
            yield from self._inside(list(entity.actions), scopes)
        elif isinstance(entity, RegisterEventHandler):
            yield from self._inside(entity.event_handler.describe()[1], scopes)
        elif isinstance(entity, GroupAction):
            yield from self._of_group(entity, scopes)
        elif isinstance(entity, IncludeLaunchDescription):
            yield from self._of_include(entity, scopes)
        elif isinstance(entity, OpaqueFunction) or not type(entity).__module__.startswith(_OURS):
            self.is_complete = False

    def _of_group(self, group: GroupAction, scopes: tuple[Scope, ...]) -> Iterator[ProcessSpec]:
        scope = described_scope(group)
        inner = scopes if scope is None else (*scopes, scope)
        self._context._push_launch_configurations()
        try:
            yield from self._inside(list(group._entries_written), inner)
        finally:
            self._context._pop_launch_configurations()

    def _of_include(
        self, include: IncludeLaunchDescription, scopes: tuple[Scope, ...]
    ) -> Iterator[ProcessSpec]:
        if len(scopes) > _MAX_DEPTH:
            return
        if not all(_is_harmless(part) for pair in include.launch_arguments for part in pair):
            self.is_complete = False
            return
        source = include.launch_description_source
        description = source.get_launch_description(self._context)
        scope = described_scope(include)  # its location is known now
        path = include._get_launch_file()
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
        if not _is_harmless(push.namespace):
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
            if _is_harmless(entity.name) and _is_harmless(entity.value):
                name = perform_substitutions(self._context, entity.name)
                configurations[name] = perform_substitutions(self._context, entity.value)
            return
        default = entity.default_value
        is_set = configurations.peek(entity.name) is not None
        if not is_set and default is not None and _is_harmless(default):
            configurations[entity.name] = perform_substitutions(self._context, default)

    # ---- processes

    def _process(self, action: ExecuteLocal, scopes: tuple[Scope, ...]) -> ProcessSpec:
        given = vars(action)
        description = action.process_description
        executable = self._text(given.get("_Node__node_executable"))
        words = description.cmd[:1]
        program = self._text(words[0]) if executable is None and words else executable
        label = os.path.basename(self._text(description.name) or program or "")
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

    def _text(self, given: Any) -> str | None:
        """The text of substitutions; None without any, or if it cannot be known."""
        if given is None:
            return None
        if _is_harmless(given):
            with contextlib.suppress(Exception):
                return str(perform(self._context, given))
        self.is_complete = False
        return None


def _is_harmless(given: Any) -> bool:
    """Whether performing these substitutions executes no command and no code of others."""
    if isinstance(given, str):
        return True
    if isinstance(given, Iterable):
        return all(map(_is_harmless, given))
    return type(given).__module__.startswith(_OURS) and not isinstance(given, Command)
