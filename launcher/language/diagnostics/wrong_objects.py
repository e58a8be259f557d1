"""Sentences for arguments that lack what an action calls: conditions, handlers, dictionaries."""

from __future__ import annotations

import ast

from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.origin import FileLine, is_own_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType, TracebackType

_MAX_CODE = 60  # characters of code in a hint
_DICTIONARIES = ("environment", "launch_configurations", "env", "additional_env")
# What an action called: what the argument should have been, and the names of such arguments.
_WANTED = {
    "evaluate": ("a condition", ("condition",)),
    "items": ("a dictionary", _DICTIONARIES),
    "prepare": ("an Executable", ("process_description",)),
}
_COMPARISONS = {ast.Eq: "EqualsSubstitution", ast.NotEq: "NotEqualsSubstitution"}


def sentence(error: BaseException, place: FileLine | None) -> tuple[str, str, str] | None:
    """(message, hint, word of the line) if an argument lacks what an action called."""
    wanted = getattr(error, "name", None)
    if not isinstance(error, AttributeError) or wanted not in _WANTED or not _is_raised_here(error):
        return None
    expected, names = _WANTED[wanted]
    given = keyword_value(place, names)
    name = names[0] if given is None else given[0]
    if given is None and len(names) > 1:
        return None
    message = f"{name} takes {expected}, not {_of_type(error.obj)}"
    value = None if given is None else given[1]
    hints = {
        "evaluate": _condition(value),
        "items": f"write {name}={{'NAME': 'VALUE'}}",
        "prepare": "write process_description=Executable(cmd=[...])",
    }
    return message, hints[wanted], name


def keyword_value(place: FileLine | None, names: tuple[str, ...]) -> tuple[str, ast.expr] | None:
    """The only argument of one of these names in the calls of this line, and its code."""
    found: list[tuple[str, ast.expr]] = []
    for node in () if place is None else source_code.nodes_at(place):
        for one in node.keywords if isinstance(node, ast.Call) else ():
            if one.arg in names:
                found.append((one.arg, one.value))
    return found[0] if len(found) == 1 else None


def _of_type(value: object) -> str:
    name = type(value).__name__
    words = {"str": "text", "NoneType": "None"}
    noun = words.get(name, name)
    if noun == "None":
        return noun
    return f"{'an' if noun[0] in 'aeiouAEIO' else 'a'} {noun}"


def _condition(value: ast.expr | None) -> str:
    if value is not None:
        compared = comparison(value)
        code = compared or ast.unparse(value)
        if isinstance(value, ast.Constant) and isinstance(value.value, (bool, int)):
            code = repr(code.lower())
        if len(code) <= _MAX_CODE or compared:
            return f"write IfCondition({code})"
    return "write IfCondition(...)"


def comparison(node: ast.expr) -> str | None:
    """`a == b` as a substitution, with `!=` as well."""
    if not isinstance(node, ast.Compare) or len(node.ops) != 1:
        return None
    name = _COMPARISONS.get(type(node.ops[0]))
    if name is None:
        return None
    return f"{name}({ast.unparse(node.left)}, {ast.unparse(node.comparators[0])})"


def comparison_at(place: FileLine | None) -> tuple[str, str] | None:
    """The only comparison in this line as a substitution, and its first word."""
    found: list[tuple[str, str]] = []
    for node in () if place is None else source_code.nodes_at(place):
        written = comparison(node)
        if written is not None and isinstance(node, ast.Compare):
            found.append((written, ast.unparse(node.left).partition("(")[0]))
    return found[0] if len(found) == 1 else None


# ---- None


def none_is_given(error: BaseException, place: FileLine | None) -> bool:
    """Whether the launch file passes None to what failed."""
    if not isinstance(error, (AttributeError, TypeError)):
        return False
    for node in () if place is None else source_code.nodes_at(place):
        if isinstance(node, ast.Call):
            values = [*node.args, *(one.value for one in node.keywords)]
            if any(isinstance(one, ast.Constant) and one.value is None for one in values):
                return True
    frame = _constructor(error.__traceback__)
    return frame is not None and _has_none(frame)


def _constructor(trace: TracebackType | None) -> FrameType | None:
    """The frame of the outermost `__init__` of the launcher."""
    while trace is not None:
        code = trace.tb_frame.f_code
        if code.co_name == "__init__" and is_own_file(code.co_filename):
            return trace.tb_frame
        trace = trace.tb_next
    return None


def _has_none(frame: FrameType) -> bool:
    """Whether an argument without a default is None."""
    code = frame.f_code
    values = frame.f_locals
    function = getattr(type(values.get("self")), "__init__", None)
    defaulted = set(getattr(function, "__kwdefaults__", None) or ())
    positional = code.co_varnames[: code.co_argcount]
    count = len(getattr(function, "__defaults__", None) or ())
    defaulted.update(positional[len(positional) - count :] if count else ())
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    return any(values.get(name, 0) is None for name in names if name not in defaulted)


def _is_raised_here(error: BaseException) -> bool:
    """Whether the launcher's code called the attribute."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and is_own_file(trace.tb_frame.f_code.co_filename)
