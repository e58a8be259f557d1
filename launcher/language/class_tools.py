"""Checks of what users pass: instances, classes, iterables."""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def is_iterable(obj: object) -> bool:
    """Like `isinstance(obj, Iterable)`, which is slow for each new class."""
    return getattr(type(obj), "__iter__", None) is not None


def is_path(obj: object) -> bool:
    """Whether it is a `pathlib.Path`; the module, which takes 3 ms, is not imported for that."""
    pathlib = sys.modules.get("pathlib")
    return pathlib is not None and isinstance(obj, pathlib.Path)


def is_a(obj: object, entity_type: type) -> bool:
    return isinstance(obj, entity_type)


def is_a_subclass(obj: object, entity_type: type) -> bool:
    """Whether `obj` is an instance of the type, or a subclass of it."""
    if isinstance(obj, entity_type):
        return True
    return isinstance(obj, type) and issubclass(obj, entity_type)


def isclassinstance(obj: object) -> bool:
    """Whether `obj` is an instance of a class, not a class itself."""
    return not isinstance(obj, type)


def ensure_argument_type(
    argument: object, types: object, argument_name: str, caller: str | None = None
) -> None:
    """TypeError unless `argument` is an instance of one of `types` or a subclass of one.

    Also if `types` is neither a type nor an iterable of types.
    """
    if isinstance(types, type) and isinstance(argument, types):
        return  # as for each text of a launch file
    allowed = _types(types)
    if any(is_a_subclass(argument, one) for one in allowed):
        return
    subject = "Expected" if caller is None else f"'{caller}' expected"
    raise TypeError(
        f"{subject} '{argument_name}' to be one of {allowed}, "
        f"but got '{argument}' of type '{type(argument)}'"
    )


def _types(given: Any) -> list[Any]:
    if isinstance(given, type):
        return [given]
    types = list(given) if is_iterable(given) and not isinstance(given, str) else [given]
    if all(isinstance(one, type) or _is_generic(one) for one in types):
        return types
    raise TypeError(
        "'ensure_argument_type()' expected 'types' to be one of "
        f"[type, collections.abc.Iterable of type], but got '{given}' of type '{type(given)}'"
    )


def _is_generic(one: object) -> bool:
    """Whether it is of `typing`, or a union of types."""
    return hasattr(one, "__origin__") or hasattr(one, "__args__")
