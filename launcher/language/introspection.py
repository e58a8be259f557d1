"""A launch description as a tree of text, without running it."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.action import Action
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.event_actions import (
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
)
from launcher.language.actions.process import ExecuteProcess
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.naming import public
from launcher.language.substitution import (
    describe_substitutions,
    normalize_to_list_of_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.description import LaunchDescription

    _Tree = tuple[str, list[Any]]


@public("launch.launch_introspector")
class LaunchIntrospector:
    """Formats launch descriptions."""

    def format_launch_description(self, launch_description: LaunchDescription) -> str:
        """The tree, one entity a line."""
        branches = [_entity(entity) for entity in launch_description.entities]
        count = f"{len(branches)} {'entity' if len(branches) == 1 else 'entities'}"
        return "\n".join([f"LaunchDescription({count})", *_lines(branches)])


def _lines(branches: list[_Tree]) -> list[str]:
    lines: list[str] = []
    for position, (text, below) in enumerate(branches):
        last = position == len(branches) - 1
        lines.append(("└── " if last else "├── ") + text)
        lines += [("    " if last else "│   ") + line for line in _lines(below)]
    return lines


def _entity(entity: object) -> _Tree:
    if not isinstance(entity, Action):
        return f"Unknown entity('{entity}')", []
    if isinstance(entity, LogInfo):
        return f"LogInfo({format_substitutions(entity.msg)})", []
    if isinstance(entity, EmitEvent):
        return f"EmitEvent(event='{entity.event.name}')", []
    if isinstance(entity, ExecuteProcess):
        return _process(entity), []
    if isinstance(entity, DeclareLaunchArgument):
        return _argument(entity), []
    if isinstance(entity, OpaqueFunction):
        name = getattr(entity._function_called, "__name__", entity._function_called)
        return f"OpaqueFunction(function='{name}')", []
    if isinstance(entity, RegisterEventHandler):
        return f"RegisterEventHandler('{entity.event_handler}'):", [_handler(entity)]
    return f"Action('{entity}')", []


def _argument(action: DeclareLaunchArgument) -> str:
    default = action.default_value
    value = "None" if default is None else format_substitutions(default)
    return (
        f"DeclareLaunchArgument(name='{action.name}', default_value={value}, "
        f"description='{action.description}')"
    )


def _process(action: ExecuteProcess) -> str:
    words = ", ".join(format_substitutions(word) for word in action.cmd)
    cwd = None if action.cwd is None else f"'{format_substitutions(action.cwd)}'"
    env = None
    if action.env is not None:
        pairs = (f"{format_substitutions(k)}: {format_substitutions(v)}" for k, v in action.env)
        env = "{" + ", ".join(pairs) + "}"
    return f"ExecuteProcess(cmd=[{words}], cwd={cwd}, env={env}, shell={action.shell})"


def _handler(register: RegisterEventHandler) -> _Tree:
    text, entities = register.event_handler.describe()
    below: Iterable[Any] = entities
    if isinstance(entities, LaunchDescriptionEntity):
        below = [entities]
    return text, [_entity(entity) for entity in below]


def format_substitutions(substitutions: object) -> str:
    """The descriptions of substitutions, joined by plus signs."""
    return describe_substitutions(normalize_to_list_of_substitutions(substitutions))
