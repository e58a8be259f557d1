"""Looks up tags and substitutions: built-in ones, then those of installed packages.

Packages register theirs by entry points of the group `launch.frontend.launch_extension`. They are
imported, which takes time, only for a name that is not built in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from launcher.base.text import did_you_mean
from launcher.language import frontend_registry
from launcher.language.frontends.entity import Entity
from launcher.language.frontends.errors import StructureError
from launcher.language.frontends.parsers import tables

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import EntryPoint
    from typing import Any

    from launcher.language.action import Action
    from launcher.language.frontends.parser import Parser

    _ParseMethod = Callable[..., Any]

EXTENSION_GROUP = "launch.frontend.launch_extension"

# Tags of ROS 1, and what to use instead.
_ROS_1_TAGS = {
    "param": "in ROS 2, write <param> inside its <node>",
    "rosparam": 'in ROS 2, write <param from="FILE"/> inside the <node>',
    "remap": "in ROS 2, write <set_remap from=... to=.../> outside of a <node>",
    "env": "in ROS 2, write <set_env name=... value=.../> outside of a <node>",
    "machine": "ROS 2 starts processes on this machine only",
    "test": "ROS 2 has launch_testing for this",
}


def instantiate_action(entity: Entity, parser: Parser) -> Action:
    """The action of an entity; RuntimeError if its name is unknown."""
    method = action_parser(entity.type_name)
    if method is None:
        raise _unknown_tag(entity)
    action_type, arguments = class_and_arguments(method, method(entity, parser))
    entity.assert_entity_completely_parsed()
    action: Action = action_type(**arguments)
    return action


def class_and_arguments(method: _ParseMethod, result: Any) -> tuple[Any, Mapping[str, Any]]:
    """What a parse method returned; TypeError if it is something else."""
    try:
        cls, arguments = result
        if callable(cls) and isinstance(arguments, Mapping):
            return cls, arguments
    except (TypeError, ValueError):
        pass
    from launcher.language.diagnostics.wrong_returns import wrong_result

    raise wrong_result(method, result, "a class and a dictionary of arguments")


def instantiate_substitution(type_name: str, args: Iterable[Any] | None = None) -> Any:
    """The substitution `$(type_name args...)`; RuntimeError if its name is unknown."""
    method = substitution_parser(type_name)
    if method is None:
        raise StructureError(f"Unknown substitution: {type_name}")
    result = method([] if args is None else list(args))
    substitution_type, arguments = class_and_arguments(method, result)
    return substitution_type(**arguments)


def action_parser(name: str) -> _ParseMethod | None:
    """The parse method for entities of this name."""
    return _find(name, frontend_registry.action_parse_methods, tables.builtin_action)


def substitution_parser(name: str) -> _ParseMethod | None:
    """The parse method for substitutions of this name."""
    return _find(name, frontend_registry.substitution_parse_methods, tables.builtin_substitution)


def action_names() -> list[str]:
    """All tags that are known now."""
    return sorted({*tables.ACTIONS, *frontend_registry.action_parse_methods})


def substitution_names() -> list[str]:
    """All substitutions that are known now."""
    return sorted({*tables.SUBSTITUTIONS, *frontend_registry.substitution_parse_methods})


def installed(group: str) -> list[EntryPoint]:
    """The entry points of a group."""
    from importlib import metadata

    points: Any = metadata.entry_points(group=group)
    # Old versions of importlib_metadata, which may replace the module, return a dictionary.
    return list(points.get(group, ()) if isinstance(points, dict) else points)


def load_extensions() -> list[str]:
    """Import the packages that expose something; the failures, one text each."""
    failures = []
    for point in installed(EXTENSION_GROUP):
        if getattr(point, "value", "").split(":")[0].split(".")[0] in ("launch", "launch_ros"):
            continue  # an installed ROS 2: its names are built in
        try:
            point.load()
        except Exception as problem:  # one broken package must not hide the others
            failures.append(f"{point.name}: {problem}")
    return failures


def failed_extensions() -> str | None:
    """A hint that names the packages with extensions that cannot be loaded."""
    failures = load_extensions()
    return (
        f"a package with extensions cannot be loaded: {'; '.join(failures)}" if failures else None
    )


def _find(
    name: object, exposed: dict[str, _ParseMethod], builtin: Callable[[str], _ParseMethod | None]
) -> _ParseMethod | None:
    if not isinstance(name, str):
        return None
    method = exposed.get(name)
    if method is None and name not in tables.NEWER:
        method = builtin(name)
    if method is None:
        load_extensions()
        method = exposed.get(name) or builtin(name)
    return method


def _unknown_tag(entity: Entity) -> StructureError:
    name = str(entity.type_name)
    hint = _ROS_1_TAGS.get(name) or did_you_mean(name, action_names())
    if hint is None:
        hint = failed_extensions()
    return StructureError(
        f"unknown action '{name}' (Unrecognized entity of the type: {name})",
        place=entity.place,
        hint=hint,
    )
