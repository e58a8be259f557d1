"""Errors about values in launch files that are not entities, with a location and a hint.

They are subclasses of what ROS 2 raises, for code that catches that.
"""

from __future__ import annotations

import functools

from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine, is_own_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    import ast
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_CODE = 60  # characters of code in a hint
_LISTS = ("initial_entities", "actions")  # keywords that take a list of entities


class _BadEntryError(Exception):
    """Base of errors with a hint and a location for `faults.explain`."""

    def __init__(self, message: str, hint: str, place: FileLine | None) -> None:
        super().__init__(message)
        known = details(self)
        known.hint, known.place = hint, place


class WrongEntryError(_BadEntryError, AttributeError):
    """An entry of a list of entities is not an entity."""

    ros_type = "AttributeError"


class NotAListError(_BadEntryError, TypeError):
    """A function returned a single object instead of a list."""

    ros_type = "TypeError"


class FromHandlerError(_BadEntryError, RuntimeError):
    """An event handler yielded something that is not an entity."""

    ros_type = "RuntimeError"


class NotAHandlerError(_BadEntryError, AttributeError):
    """What is registered is not an event handler."""

    ros_type = "AttributeError"


class NotFieldsError(_BadEntryError, TypeError):
    """What is between two semicolons in the values of a loop names no fields."""

    ros_type = "TypeError"


class NoCommandError(IndexError):
    """A process has no words in its command."""

    ros_type = "IndexError"

    def __init__(self) -> None:
        super().__init__("a process has an empty command: cmd=[]")
        hint = "cmd takes the program and its arguments, as in cmd=['sleep', '5']"
        details(self).hint = hint


def is_entity(item: object) -> bool:
    """Whether it can be visited; a class cannot, only its instances."""
    return hasattr(type(item), "visit")


def is_entity_class(cls: type) -> bool:
    return hasattr(cls, "visit")


def wrong_entry(item: Any, holder: Any, entries: Any) -> WrongEntryError:
    """The error about `item`, one of the `entries` of an entity or of its function's result."""
    if holder._to_arguments == "includes":
        return WrongEntryError(
            f"the included launch file returns {shown(item)}, not a LaunchDescription",
            "end its generate_launch_description() with return LaunchDescription([...])",
            holder._origin,
        )
    function = getattr(holder, "_function_called", None)
    written = getattr(holder, "_entries_written", None) or entries
    index = next((at for at, one in enumerate(written) if one is item), None)
    among = "an entry" if index is None else f"entry {index + 1} of {len(written)}"
    node = None
    if function is not None:
        source, place = f"what {name_of(function)}() returned", return_place(function)
    else:
        node = _entry_node(holder, index)
        source, place = f"{type(holder).__name__}([...])", holder._origin
    if node is not None and place is not None:
        place = FileLine(place.path, node.lineno)
    return WrongEntryError(
        f"{among} in {source} is not an action: {shown(item)}", _repair(item, holder, node), place
    )


def from_handler(item: Any, handler: Any, event: object) -> FromHandlerError:
    """The error about `item`, which a handler returned for an event."""
    function = getattr(handler, "_function_called", None)
    place = None if function is None else return_place(function)
    if place is None:
        place = getattr(getattr(event, "action", None), "_origin", None)
    message = f"expected a LaunchDescriptionEntity from event_handler, got '{item}'"
    return FromHandlerError(message, _repair(item, handler), place)


def not_a_handler(item: object, action: Any) -> NotAHandlerError:
    """The error about what a RegisterEventHandler was given instead of a handler."""
    error = NotAHandlerError(
        f"RegisterEventHandler takes an event handler, not {shown(item)}",
        "write RegisterEventHandler(OnProcessExit(target_action=..., on_exit=[...]))",
        action._origin,
    )
    details(error).word = "RegisterEventHandler"
    return error


def not_a_list(result: object, holder: Any) -> TypeError | AttributeError:
    """The error about a function, or an `execute` method, that did not return a list."""
    function = getattr(holder, "_function_called", None)
    source = f"{type(holder).__name__}.execute" if function is None else name_of(function)
    place = holder._origin if function is None else return_place(function)
    hint = "return a list of actions, or nothing"
    if is_entity(result):
        hint = f"return [{type(result).__name__}(...)]"
    kind = WrongEntryError if isinstance(result, str) else NotAListError
    return kind(f"{source}() did not return a list of actions: {shown(result)}", hint, place)


def no_field_set(found: object, part: str, origin: FileLine | None) -> NotFieldsError:
    """The error about one of the values of a loop, `part` as it is written."""
    part = " ".join(part.split())
    name = _in_markup(origin, "values", "input_values")
    if isinstance(found, dict):
        wrong = next(key for key in found if not isinstance(key, str))
        message = f"the name {wrong!r} in '{part}' of {name} is not a text"
        return NotFieldsError(message, f"write {{'{wrong}': ...}}", origin)
    return NotFieldsError(f"'{part}' of {name} is no mapping", f"write {{name: {part}}}", origin)


def explain_field_set(error: BaseException, part: str, origin: FileLine | None) -> None:
    """Attach what is wrong to the error of reading one of the values of a loop as YAML."""
    from launcher.base.yaml_bounds import message_of

    known, name = details(error), _in_markup(origin, "values", "input_values")
    part = " ".join(part.split())
    known.message = f"'{part}' of {name} is not valid YAML: {message_of(error)}"  # type: ignore[arg-type]
    known.hint = f"{name} are written {{name: value, other: value}}; {{name: value}}"


def explain_length(error: BaseException, text: str, origin: FileLine | None) -> None:
    """Attach what is wrong to the error about the length of a loop."""
    name = _in_markup(origin, "len", "length")
    details(error).message = f"{name} is '{text}', which is not a whole number"
    details(error).word = name


def _in_markup(origin: FileLine | None, markup: str, python: str) -> str:
    return python if origin is None or origin.is_python else markup


def return_place(function: object) -> FileLine | None:
    """The line of the function's only `return VALUE`, else that of the function."""
    while isinstance(function, functools.partial):
        function = function.func
    code = getattr(function, "__code__", None)
    if code is None or code.co_filename.startswith("<") or is_own_file(code.co_filename):
        return None
    place = place_of_return(code.co_filename, code.co_name, after=code.co_firstlineno)
    return place or FileLine(code.co_filename, code.co_firstlineno)


def place_of_return(path: str, name: str, *, after: int = 1) -> FileLine | None:
    """Like `return_place`, for the first function of this name at or after line `after`."""
    import ast

    node = source_code.function_at(path, name, after=after)
    if node is None:
        return None
    returns = [one for one in source_code.own_nodes(node) if isinstance(one, ast.Return)]
    values = [one for one in returns if one.value]
    return FileLine(path, values[0].lineno if len(values) == 1 else node.lineno)


# Names in functions that hand over actions in another way than by returning them.
_USES = frozenset(
    ("add_action", "add_entity", "emit_event", "execute", "register_event_handler", "visit")
)


def warn_of_forgotten_return(function: Any, context: LaunchContext) -> None:
    """A function makes actions, returns nothing, and hands them to nobody else."""
    import ast

    code = function.__code__
    if set(code.co_names) & _USES or code.co_freevars or code.co_filename.startswith("<"):
        return
    node = source_code.function_at(code.co_filename, code.co_name, after=code.co_firstlineno)
    inside = [] if node is None else list(source_code.own_nodes(node))
    if any(isinstance(one, ast.Return) and one.value for one in inside):
        return
    for one in inside:
        if isinstance(one, ast.Call):
            made = function.__globals__.get(ast.unparse(one.func))
            if isinstance(made, type) and is_entity_class(made):
                text = f"{code.co_name}() returns nothing, so its {made.__name__} is not run"
                hint = "return a list of the actions at its end"
                origin = FileLine(code.co_filename, one.lineno)
                context._host.warn_quirk(f"{text}; hint: {hint}", origin)
                return


def returned_instead(path: str, result: object) -> str:
    """What `generate_launch_description()` should return instead of `result`."""
    import ast

    node = source_code.function_at(path, "generate_launch_description")
    if result is not None or node is None:
        what = "" if result is None else ", also for a single action"
        return "return LaunchDescription([...])" + (what if is_entity(result) else "")
    for one in source_code.own_nodes(node):
        match one:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Call(func=function)):
                if ast.unparse(function).endswith("LaunchDescription"):
                    return f"write 'return {name}' at its end"
            case ast.Expr(value=ast.Call(func=function)):
                if ast.unparse(function).endswith("LaunchDescription"):
                    return "write 'return' in front of LaunchDescription([...])"
    return "return LaunchDescription([...])"


def _entry_node(holder: Any, index: int | None) -> ast.expr | None:
    """The code of the entry if the call lists it literally."""
    import ast

    origin: FileLine | None = holder._origin
    if origin is None or index is None:
        return None
    call = source_code.call_at(origin, type(holder).__name__)
    if call is None:
        return None
    keywords = [one.value for one in call.keywords if one.arg in _LISTS]
    for several in [*call.args[:1], *keywords]:
        entries = several.elts if isinstance(several, (ast.List, ast.Tuple)) else []
        is_plain = not any(isinstance(one, ast.Starred) for one in entries[: index + 1])
        if index < len(entries) and is_plain:
            return entries[index]
    return None


# ---- texts of the messages


def name_of(function: object) -> str:
    """The name of a function, also of a partial one."""
    while isinstance(function, functools.partial):
        function = function.func
    return str(getattr(function, "__name__", type(function).__name__))


def shown(item: object) -> str:
    """A value in a message."""
    import reprlib

    if is_entity(item):
        return f"a {type(item).__name__}"
    if isinstance(item, (list, tuple, set)) and any(map(is_entity, item)):
        return f"a {type(item).__name__} of actions"
    if repr(item) == object.__repr__(item):  # which gives an address
        return f"a {type(item).__module__}.{type(item).__qualname__}"
    short = reprlib.Repr()
    short.maxother = short.maxstring = 60
    return short.repr(item)


def _unpacked(node: ast.expr | None) -> str:
    """How to write a list of actions so that its items become entries."""
    import ast

    if isinstance(node, (ast.List, ast.Tuple)):
        return "write its actions without the inner brackets"
    if isinstance(node, (ast.Name, ast.Call, ast.Attribute)):
        code = ast.unparse(node)
        if len(code) <= _MAX_CODE:
            return f"unpack it: write *{code}"
    return "unpack it, as in [first, *others]"


def _repair(item: object, holder: object, node: ast.expr | None = None) -> str:
    from launcher.language.events.base import BaseEventHandler, Event

    kind = item if isinstance(item, type) else type(item)
    name = kind.__name__
    if item is None:
        return "remove it; an optional action takes a condition"
    if isinstance(item, str):
        return (
            "LogInfo(msg=...) prints a text; Node(...) and ExecuteProcess(cmd=[...]) run programs"
        )
    if isinstance(item, (list, tuple, set)):
        return _unpacked(node)
    if issubclass(kind, Event):
        action = "; or take Shutdown from launch.actions" if name == "Shutdown" else ""
        return f"an event is emitted by EmitEvent(event={name}(...)){action}"
    if isinstance(item, type):
        return f"{name} is a class: call it, as in {name}(...)"
    if isinstance(item, BaseEventHandler):
        return f"a handler is registered by RegisterEventHandler({name}(...))"
    if hasattr(kind, "get_launch_description"):
        return f"a launch file is included by IncludeLaunchDescription({name}(...))"
    if hasattr(kind, "perform"):
        return "a substitution is a value for an action, as in LogInfo(msg=...)"
    if callable(item):
        return f"a function is called by OpaqueFunction(function={name_of(item)})"
    if kind.__module__.startswith(("launch.descriptions", "launch_ros.descriptions")):
        package = kind.__module__.partition(".")[0]
        return f"import {name} from {package}.actions instead of {package}.descriptions"
    return f"{type(holder).__name__} takes actions, such as Node(...) or LogInfo(...)"
