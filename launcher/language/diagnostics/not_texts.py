"""Sentences for errors of Python about a substitution that a launch file uses as a text."""

from __future__ import annotations

import ast
import re

from launcher.base.text import suggest
from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.origin import FileLine
from launcher.language.substitution import Substitution

_JOINS = ("os.path.join", "path.join", "osp.join", "join")
_TAKE_TEXT = ("open", "Path", "int", "float", "exists", "isfile", "isdir")
_MAX_SHOWN = 100  # characters of code in a hint
# What Python says about a value that is no text, number or list; the group is its class.
_REFUSED = (
    re.compile(r", not '?(\w+)'?$"),
    re.compile(r"^unsupported operand .*'(\w+)' and"),
    re.compile(r"^unsupported operand .* and '(\w+)'$"),
    re.compile(r"not supported between instances of '(\w+)'"),
    re.compile(r"not supported between instances of .* and '(\w+)'$"),
    re.compile(r"can only concatenate \w+ \(not \"(\w+)\"\)"),
    re.compile(r"^'(\w+)' object (?:is not|cannot be|does not|has no)"),
    re.compile(r"^object of type '(\w+)' has no len"),
    re.compile(r"expected str instance, (\w+) found$"),
)
_OBJECT = re.compile(r"<launch[\w.]*\.(\w+) object at 0x\w+>")


def sentence(error: BaseException, place: FileLine | None) -> tuple[str, str, str] | None:
    """(message, hint, word of the line) if the cause is a substitution used as text."""
    text = str(error)
    found = _OBJECT.search(text)
    if found and isinstance(error, OSError):
        name = found[1]
        message = f"the file name holds a {name} that was used as text: {text}"
        return message, _performed(name, place), name
    if not isinstance(error, (TypeError, AttributeError)):
        return None
    if isinstance(error, AttributeError):
        return _no_attribute(error, place)
    names = _class_names()
    named = [name for pattern in _REFUSED for name in pattern.findall(text) if name in names]
    if not named:
        return None
    name = named[0]
    message = f"a {name} is not a text: it gets its value only when the launch file is run"
    return message, _instead(text, place) or _performed(name, place), name


def _no_attribute(error: AttributeError, place: FileLine | None) -> tuple[str, str, str] | None:
    wanted = getattr(error, "name", None)
    if not wanted or not isinstance(error.obj, Substitution):
        return None
    name = type(error.obj).__name__
    near = suggest(wanted, [one for one in dir(error.obj) if not one.startswith("_")])
    if near:
        return f"a {name} has no attribute '{wanted}'", f"did you mean '{near}'?", wanted
    if not hasattr(str, wanted):
        return None
    message = f"a {name} is not a text and has no method {wanted}(): it gets its value only when "
    return message + "the launch file is run", _performed(name, place), wanted


def _class_names() -> set[str]:
    names: set[str] = set()
    waiting: list[type] = [Substitution]
    while waiting:
        cls = waiting.pop()
        waiting += cls.__subclasses__()
        names.add(cls.__name__)
    return names


def _instead(text: str, place: FileLine | None) -> str | None:
    """The expression of this line that Python refused with this text, with substitutions."""
    for node in () if place is None else source_code.nodes_at(place):
        better = _with_substitutions(node, text)
        if better is not None and len(better) <= _MAX_SHOWN:
            return f"write {better}"
    return None


def _with_substitutions(node: ast.expr, text: str) -> str | None:
    if isinstance(node, ast.Call) and "PathLike" in text and ast.unparse(node.func) in _JOINS:
        return _path_join(node.args)
    if not isinstance(node, ast.BinOp):
        return None
    if isinstance(node.op, ast.Div) and " /:" in text:
        return _path_join([node.left, node.right])
    if isinstance(node.op, ast.Add) and (" +:" in text or "concatenate" in text):
        return f"[{', '.join(map(ast.unparse, _summands(node)))}]"
    return None


def _path_join(parts: list[ast.expr]) -> str:
    return f"PathJoinSubstitution([{', '.join(map(ast.unparse, parts))}])"


def _summands(node: ast.expr) -> list[ast.expr]:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return [*_summands(node.left), *_summands(node.right)]
    return [node]


def _performed(name: str, place: FileLine | None) -> str:
    """`write d.perform(context) in an OpaqueFunction`, with the code of the substitution."""
    written = f"{name}(...)"
    for node in () if place is None else source_code.nodes_at(place):
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func).rpartition(".")[2]
        if called == name:
            written = ast.unparse(node)
            break
        if called in _TAKE_TEXT and node.args and isinstance(node.args[0], ast.Name):
            written = node.args[0].id
            break
    return f"write {written}.perform(context) in the function of an OpaqueFunction"
