"""Keyword arguments that a class does not have, and what was probably meant."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator

from launcher.base.text import suggest
from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.origin import FileLine

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType

_MISSING = re.compile(r"(\w+)\.__init__\(\) missing \d+ required [\w-]+ arguments?: (.*)$")
_UNKNOWN = re.compile(r"(\w+)\.__init__\(\) got an unexpected keyword argument '(\w+)'$")
OF_MARKUP = {"exec": "executable", "pkg": "package"}  # attributes of XML


def sentence(error: BaseException, place: FileLine | None) -> tuple[str, str, str, FileLine] | None:
    """(message, hint, word, place) for an error about the arguments of a class; None.

    Where a required argument is misspelt, Python names only what is missing.
    """
    text = str(error)
    found = _MISSING.search(text) or _UNKNOWN.search(text)
    if found is None or place is None:
        return None
    for cls, call in _calls(error, place):
        if all(base.__name__ != found[1] for base in cls.__mro__):
            continue
        names = _names(cls)
        unknown = [one for one in call.keywords if one.arg and one.arg not in names]
        missing = re.findall(r"'(\w+)'", found[2]) if found.re is _MISSING else []
        for one in unknown:
            word = one.arg or ""
            meant = _meant(word, names - {other.arg or "" for other in call.keywords})
            if meant is None and len(unknown) == len(missing) == 1:
                meant = missing[0]
            if meant is not None and (missing or word == found[2]):
                hint = f"did you mean '{meant}'?"
                if not missing:
                    return f"TypeError: {text}", hint, word, place
                at = FileLine(place.path, one.lineno)
                return f"{cls.__name__} has no argument '{word}'", hint, word, at
    return None


def _meant(word: str, names: set[str]) -> str | None:
    in_markup = OF_MARKUP.get(word)
    return in_markup if in_markup in names else suggest(word, sorted(names))


def _calls(error: BaseException, place: FileLine) -> Iterator[tuple[type, ast.Call]]:
    """The classes that are called in the line, inner calls first, which fail first."""
    frame = _frame(error, place)
    for node in reversed(list(source_code.nodes_at(place))):
        if frame is not None and isinstance(node, ast.Call):
            cls = _value(node.func, frame)
            if isinstance(cls, type):
                yield cls, node


def _frame(error: BaseException, place: FileLine) -> FrameType | None:
    found, trace = None, error.__traceback__
    while trace is not None:
        frame = trace.tb_frame
        if (frame.f_code.co_filename, trace.tb_lineno) == (place.path, place.line):
            found = frame
        trace = trace.tb_next
    return found


def _value(node: ast.expr, frame: FrameType) -> object:
    """What a name, or a dotted name, stands for in the frame; None if it is unknown."""
    if isinstance(node, ast.Name):
        return frame.f_locals.get(node.id, frame.f_globals.get(node.id))
    if isinstance(node, ast.Attribute):
        return inspect.getattr_static(_value(node.value, frame), node.attr, None)
    return None


def _names(cls: type) -> set[str]:
    """The arguments that the class takes by name, those of its base classes included."""
    names: set[str] = set()
    for base in cls.__mro__:
        if "__init__" not in vars(base) or base is object:
            continue
        parameters = inspect.signature(vars(base)["__init__"]).parameters.values()
        by_name = (inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        names.update(one.name for one in parameters if one.kind in by_name)
        if all(one.kind is not one.VAR_KEYWORD for one in parameters):
            break
    return names - {"self"}
