"""Errors about values in launch files that are not entities, with a location and a hint.

They are subclasses of what ROS 2 raises, for code that catches that.
"""

from __future__ import annotations

import functools

from launcher.language.diagnostics.origin import Origin, is_own_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    import ast
    from collections.abc import Iterator
    from typing import Any

_LISTS = ("initial_entities", "actions")  # keywords that take a list of entities


class _BadEntryError(Exception):
    """Base of errors with a hint and a location for `faults.explain`."""

    def __init__(self, message: str, hint: str, place: Origin | None) -> None:
        super().__init__(message)
        self._launcher_hint = hint
        self._launcher_place = place


class WrongEntryError(_BadEntryError, AttributeError):
    """An entry of a list of entities is not an entity."""

    ros_type = "AttributeError"


class NotAListError(_BadEntryError, TypeError):
    """A function returned a single object instead of a list."""

    ros_type = "TypeError"


class FromHandlerError(_BadEntryError, RuntimeError):
    """An event handler yielded something that is not an entity."""

    ros_type = "RuntimeError"


class NoCommandError(IndexError):
    """A process has no words in its command."""

    ros_type = "IndexError"
    _launcher_hint = "cmd takes the program and its arguments, as in cmd=['sleep', '5']"

    def __init__(self) -> None:
        super().__init__("a process has an empty command: cmd=[]")


def is_entity(item: Any) -> bool:
    """Whether it can be visited; a class cannot, only its instances."""
    return hasattr(type(item), "visit")


def wrong_entry(item: Any, holder: Any, entries: Any) -> WrongEntryError:
    """The error about `item`, one of the `entries` of an entity or of its function's result."""
    if holder._to_arguments == "includes":
        return WrongEntryError(
            f"the included launch file returns {_shown(item)}, not a LaunchDescription",
            "end its generate_launch_description() with return LaunchDescription([...])",
            holder._origin,
        )
    function = getattr(holder, "_function_called", None)
    written = getattr(holder, "_entries_written", None) or entries
    index = next((at for at, one in enumerate(written) if one is item), None)
    among = "an entry" if index is None else f"entry {index + 1} of {len(written)}"
    if function is not None:
        source, place = f"what {_name(function)}() returned", return_place(function)
    else:
        source, place = f"{type(holder).__name__}([...])", _entry_place(holder, index)
    return WrongEntryError(
        f"{among} in {source} is not an action: {_shown(item)}", _repair(item, holder), place
    )


def from_handler(item: Any, handler: Any, event: Any) -> FromHandlerError:
    """The error about `item`, which a handler returned for an event."""
    function = getattr(handler, "_function_called", None)
    place = None if function is None else return_place(function)
    if place is None:
        place = getattr(getattr(event, "action", None), "_origin", None)
    message = f"expected a LaunchDescriptionEntity from event_handler, got '{item}'"
    return FromHandlerError(message, _repair(item, handler), place)


def not_a_list(result: Any, holder: Any) -> TypeError | AttributeError:
    """The error about a function, or an `execute` method, that did not return a list."""
    function = getattr(holder, "_function_called", None)
    source = f"{type(holder).__name__}.execute" if function is None else _name(function)
    place = holder._origin if function is None else return_place(function)
    hint = "return a list of actions, or nothing"
    if is_entity(result):
        hint = f"return [{type(result).__name__}(...)]"
    kind = WrongEntryError if isinstance(result, str) else NotAListError
    return kind(f"{source}() did not return a list of actions: {_shown(result)}", hint, place)


def return_place(function: Any) -> Origin | None:
    """The line of the function's only `return VALUE`, else that of the function."""
    while isinstance(function, functools.partial):
        function = function.func
    code = getattr(function, "__code__", None)
    if code is None or code.co_filename.startswith("<") or is_own_file(code.co_filename):
        return None
    place = place_of_return(code.co_filename, code.co_name, after=code.co_firstlineno)
    return place or Origin(code.co_filename, code.co_firstlineno)


def place_of_return(path: str, name: str, *, after: int = 1) -> Origin | None:
    """Like `return_place`, for the first function of this name at or after line `after`."""
    import ast

    for node in _nodes(path):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and node.name == name:
            if node.lineno < after:
                continue
            returns = [one for one in _own_nodes(node) if isinstance(one, ast.Return) and one.value]
            return Origin(path, returns[0].lineno if len(returns) == 1 else node.lineno)
    return None


def _own_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function without those of nested functions."""
    import ast

    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            yield from _own_nodes(child)


def _entry_place(holder: Any, index: int | None) -> Origin | None:
    """The line of the entry if the call lists it literally, else the line of the call."""
    import ast

    origin: Origin | None = holder._origin
    if origin is None or index is None:
        return origin
    for node in _nodes(origin.path):
        if not isinstance(node, ast.Call) or node.lineno != origin.line:
            continue
        name = getattr(node.func, "id", getattr(node.func, "attr", None))
        keywords = [one.value for one in node.keywords if one.arg in _LISTS]
        for several in [*node.args[:1], *keywords] if name == type(holder).__name__ else ():
            entries = several.elts if isinstance(several, (ast.List, ast.Tuple)) else []
            is_plain = not any(isinstance(one, ast.Starred) for one in entries[: index + 1])
            if index < len(entries) and is_plain:
                return Origin(origin.path, entries[index].lineno)
    return origin


def _nodes(path: str) -> Iterator[ast.AST]:
    import ast
    import linecache

    try:
        tree = ast.parse("".join(linecache.getlines(path)))
    except (SyntaxError, ValueError):  # fall back on the line of the call
        return
    yield from ast.walk(tree)


# ---- texts of the messages


def _name(function: Any) -> str:
    while isinstance(function, functools.partial):
        function = function.func
    return str(getattr(function, "__name__", type(function).__name__))


def _shown(item: Any) -> str:
    import reprlib

    if is_entity(item):
        return f"a {type(item).__name__}"
    if isinstance(item, (list, tuple, set)) and any(map(is_entity, item)):
        return f"a {type(item).__name__} of actions"
    short = reprlib.Repr()
    short.maxother = short.maxstring = 60
    return short.repr(item)


def _repair(item: Any, holder: Any) -> str:
    from launcher.language.events.base import BaseEventHandler, Event
    from launcher.language.substitution import Substitution

    kind = item if isinstance(item, type) else type(item)
    name = kind.__name__
    if item is None:
        return "remove it; an optional action takes a condition"
    if isinstance(item, str):
        return (
            "LogInfo(msg=...) prints a text; Node(...) and ExecuteProcess(cmd=[...]) run programs"
        )
    if isinstance(item, (list, tuple, set)):
        return "unpack it, as in [first, *others]"
    if issubclass(kind, Event):
        action = "; or take Shutdown from launch.actions" if name == "Shutdown" else ""
        return f"an event is emitted by EmitEvent(event={name}(...)){action}"
    if isinstance(item, type):
        return f"{name} is a class: call it, as in {name}(...)"
    if isinstance(item, BaseEventHandler):
        return f"a handler is registered by RegisterEventHandler({name}(...))"
    if hasattr(kind, "get_launch_description"):
        return f"a launch file is included by IncludeLaunchDescription({name}(...))"
    if isinstance(item, Substitution):
        return "a substitution is a value for an action, as in LogInfo(msg=...)"
    if callable(item):
        return f"a function is called by OpaqueFunction(function={_name(item)})"
    return f"{type(holder).__name__} takes actions, such as Node(...) or LogInfo(...)"
