"""Errors about what methods and functions of a launch file return.

They are TypeErrors, as what ROS 2 raises where it uses the value.
"""

from __future__ import annotations

import os

from launcher.language.diagnostics.bad_entries import name_of, return_place, shown
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine, is_own_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import Any

    from launcher.language.context import LaunchContext

_TEXT = "a text"


class WrongReturnError(TypeError):
    """A method returned what it must not; with hint and place for `faults.explain`."""

    ros_type = "TypeError"

    def __init__(self, message: str, hint: str, place: FileLine | None) -> None:
        super().__init__(message)
        known = details(self)
        known.message, known.hint, known.place = message, hint, place


class NoDescriptionReturnedError(WrongReturnError, AttributeError):
    """A launch file, or a source of one, returned no LaunchDescription."""

    ros_type = "AttributeError"


def wrong_return(
    owner: object, methods: str | Sequence[str], value: object, expected: str
) -> TypeError:
    """The error about a value that the first of the methods that `owner` overrides returned."""
    names = [methods] if isinstance(methods, str) else methods
    own = [(name, function) for name in names if (function := _overriding(owner, name))]
    name, function = own[0] if own else (names[0], None)
    place = None if function is None else return_place(function)
    message = f"{type(owner).__name__}.{name}() returned {shown(value)}, not {expected}"
    return WrongReturnError(message, _hint(value, expected), place or _origin(owner))


def wrong_result(function: object, value: object, expected: str) -> TypeError:
    """The same about a function, or the bound method of a class."""
    name = getattr(function, "__qualname__", name_of(function)).rpartition("<locals>.")[2]
    place = return_place(getattr(function, "__func__", function))
    message = f"{name}() returned {shown(value)}, not {expected}"
    where = f", in {place}" if place else ""
    return WrongReturnError(message, _hint(value, expected) + where, place)


def no_text(subs: Iterable[Any], texts: Sequence[Any]) -> TypeError:
    """The error about the first substitution whose `perform` gave something else than a text."""
    pairs = zip(subs, texts, strict=False)
    sub, value = next((sub, text) for sub, text in pairs if not isinstance(text, str))
    if _overriding(sub, "perform") is not None:
        return wrong_return(sub, "perform", value, _TEXT)
    message = f"{sub.describe()} is {shown(value)}, not a text"
    return WrongReturnError(message, "set it to a text, as in str(...)", _origin(sub))


def no_description(include: Any, value: object) -> NoDescriptionReturnedError:
    """The error about an include that gave no LaunchDescription."""
    from launcher.language.diagnostics.bad_entries import place_of_return, returned_instead

    source, required = include.launch_description_source, "generate_launch_description"
    for name in ("get_launch_description", "_get_launch_description"):
        function = _overriding(source, name)
        if function is not None:
            message = f"{type(source).__name__}.{name}() returned {shown(value)}"
            place, hint = return_place(function), "return a LaunchDescription"
            return NoDescriptionReturnedError(f"{message}, not a LaunchDescription", hint, place)
    path = include._get_launch_file()
    place = place_of_return(path, required) or include._origin
    message = f"{required}() of {path} returned {shown(value)}, not a LaunchDescription"
    return NoDescriptionReturnedError(message, returned_instead(path, value), place)


def warn_of_no_truth(condition: Any, value: object, context: LaunchContext) -> None:
    """A condition gave neither true nor false: as in ROS 2, what is empty counts as false."""
    predicate = getattr(condition, "_predicate", None)
    function = _overriding(condition, "evaluate") or predicate
    what = f"{type(condition).__name__}.evaluate()"
    if function is predicate:
        what = f"{name_of(predicate)}(), a predicate of {type(condition).__name__},"
    text = f"{what} returned {shown(value)}, which counts as {'true' if value else 'false'}"
    place = return_place(function) or condition._origin
    context._host.warn_quirk(f"{text}; hint: return True or False", place)


def _overriding(owner: object, name: str) -> Any:
    """The method of the launch file, or a package, that `owner` has; None for one of launch."""
    function = getattr(type(owner), name, None)
    code = getattr(function, "__code__", None)
    return None if code is None or is_own_file(code.co_filename) else function


def _origin(owner: object) -> FileLine | None:
    return getattr(owner, "_origin", None)


def _hint(value: object, expected: str) -> str:
    if expected == _TEXT and isinstance(value, (bool, int, float, os.PathLike)):
        return "write 'return str(...)'"
    if expected == _TEXT and hasattr(type(value), "perform"):
        return "write 'return ....perform(context)'"
    return f"return {expected}"
