"""Names of launch configurations that a launch file may read at some time.

A dry run records the names that are read with the given arguments. What is behind a false
condition, or an event that does not happen, is searched for in the objects that the launch file
has created.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from types import CodeType, FunctionType, MethodType

from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.compat import vocabulary
from launcher.language.conditions import LaunchConfigurationEquals
from launcher.language.context import LaunchContext
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.substitution import TextSubstitution
from launcher.language.substitutions.configuration import LaunchConfiguration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.planner import Plan

_MAX_OBJECTS = 200_000  # the search ends there
_VOCABULARY = ("launch", "launch_ros", "launch_xml", "launch_yaml", "launcher")


def known_names(plan: Plan) -> frozenset[str]:
    """The names that the dry run has read, and those in parts that it did not reach."""
    if plan.description is None:
        return plan.known_names
    with vocabulary():  # files that are included under a condition are loaded now
        return plan.known_names | _names_in(plan.description)


def _names_in(description: Any) -> frozenset[str]:
    names: set[str] = set()
    seen: dict[int, Any] = {}  # the objects are kept, or an id might be used again
    waiting: list[Any] = [description]
    while waiting and len(seen) < _MAX_OBJECTS:
        part = waiting.pop()
        if id(part) in seen or isinstance(part, (str, bytes, int, float, LaunchContext)):
            continue
        seen[id(part)] = part
        names.update(_names_of(part))
        with contextlib.suppress(Exception):  # code of the launch file is in some of them
            waiting += _parts_of(part)
    return frozenset(names)


def _names_of(part: Any) -> Iterable[str]:
    """Names that this object itself reads."""
    if isinstance(part, DeclareLaunchArgument):
        return [part.name]
    if isinstance(part, LaunchConfigurationEquals):
        return [part.launch_configuration_name]
    if isinstance(part, LaunchConfiguration):
        texts = [sub.text for sub in part.variable_name if isinstance(sub, TextSubstitution)]
        return ["".join(texts)]
    if isinstance(part, (FunctionType, MethodType)):
        return _texts_in(part.__code__)
    return ()


def _texts_in(code: CodeType) -> Iterator[str]:
    """Every string constant of a function, since it may be a name that it reads."""
    for constant in code.co_consts:
        if isinstance(constant, str):
            yield constant
        elif isinstance(constant, tuple):
            yield from (item for item in constant if isinstance(item, str))
        elif isinstance(constant, CodeType):
            yield from _texts_in(constant)


def _parts_of(part: Any) -> list[Any]:
    if isinstance(part, Mapping):
        return [*part.keys(), *part.values()]
    if isinstance(part, (list, tuple, set, frozenset)):
        return list(part)
    if isinstance(part, MethodType):
        return [part.__self__]
    if isinstance(part, FunctionType):
        return [cell.cell_contents for cell in part.__closure__ or ()]
    parts: list[Any] = []
    if isinstance(part, LaunchDescriptionEntity):
        parts += part.describe_sub_entities()
        parts += [entities for _, entities in part.describe_conditional_sub_entities()]
    if _is_of_the_vocabulary(type(part)):
        parts += vars(part).values()
    return parts


def _is_of_the_vocabulary(cls: type) -> bool:
    return any(base.__module__.partition(".")[0] in _VOCABULARY for base in cls.__mro__)
