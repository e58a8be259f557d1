"""Conditions on a message, a response or a parameter: expressions and field values."""

from __future__ import annotations

import ast
import itertools
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import CodeType
from typing import Any

from launcher.base import strict_json
from launcher.base.text import did_you_mean

_BUILTINS = {
    f.__name__: f
    for f in (abs, all, any, bool, dict, float, int, isinstance, len, list, max, min, round)
} | {f.__name__: f for f in (set, sorted, str, sum, tuple, zip, range, enumerate)}
_CONSTANTS = {"true": "True", "false": "False", "null": "None", "none": "None"}  # as in YAML
_EXPONENT = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+")
# The methods of these are available. Others lead elsewhere, as the frame of a generator does.
_PLAIN = (bool, dict, float, int, list, range, set, str, tuple)
# A format text can name attributes ('{0.__class__}'), and `mro` leads to `object`.
_WITHHELD = ("format", "format_map", "mro")
_GUARD = "_attribute"  # no expression can use the name
STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")
_SHOWN = 8  # fields in a sentence
_MOST_SHOWN = 200  # characters of an expression in a sentence


class Fields:
    """A mapping with its entries as attributes, as in `m.pose.x`, whatever their names."""

    __slots__ = ("_fields",)

    def __init__(self, fields: dict[str, Any]) -> None:
        self._fields = fields

    def __getattr__(self, name: str) -> Any:
        try:
            return self._fields[name]
        except KeyError:
            raise AttributeError(_no_field(name, self._fields)) from None

    def __getitem__(self, name: str) -> Any:
        return self._fields[name]

    def __contains__(self, name: object) -> bool:
        return name in self._fields

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __eq__(self, other: object) -> bool:
        return self._fields == (other._fields if isinstance(other, Fields) else other)

    def __hash__(self) -> int:
        raise TypeError("unhashable: fields of a message")


def _no_field(path: str, known: Collection[str]) -> str:
    """With the known names, unless it is a path, whose end they may not belong to."""
    sentence = f"unknown field '{path}'"
    if not known or any(sign in path for sign in ".["):
        return sentence
    shown = ", ".join(itertools.islice(known, _SHOWN)) + " ..." * (len(known) > _SHOWN)
    return f"{sentence}; known: {shown}"


def viewed(value: Any) -> Any:
    """Plain JSON with attributes for its fields."""
    if isinstance(value, Mapping):
        return Fields({name: viewed(entry) for name, entry in value.items()})
    return [viewed(entry) for entry in value] if isinstance(value, list) else value


def json_of(content: object) -> Any:
    """The JSON in a string field `data`, with attributes; None if there is none."""
    text = content.get("data") if isinstance(content, Mapping) else None
    if not isinstance(text, str):
        return None
    try:
        return viewed(strict_json.unpacked(text))
    except ValueError:
        return None


@dataclass(frozen=True, slots=True)
class Expression:
    """A Python expression over `m` (the message) and `json` (the JSON in its string `data`).

    Names with a leading underscore are rejected; only a few builtins, fields, and the methods of
    plain values are available. What it costs is limited by `evaluator`.
    """

    text: str
    code: CodeType

    @staticmethod
    def parse(text: object) -> Expression:
        if not isinstance(text, str):
            raise ValueError(f"{text!r} is not an expression")
        try:
            tree = ast.parse(text.strip(), mode="eval")
            _check_names(tree)
            guarded = ast.fix_missing_locations(_Guarded().visit(tree))
            return Expression(text, compile(guarded, "<expectation>", "eval"))
        except SyntaxError as error:
            raise ValueError(f"'{_start(text)}' is not a Python expression: {error.msg}") from None
        except (RecursionError, MemoryError):  # thousands of brackets
            raise ValueError(f"'{_start(text)}' is nested too deeply") from None

    def __reduce__(self) -> tuple[Any, ...]:
        return Expression.parse, (self.text,)

    def holds(self, content: object) -> tuple[bool, str | None]:
        """Whether it is true, and the error if its evaluation failed; MemoryError.

        Nothing limits its time.
        """
        names = {"m": viewed(content), "json": json_of(content), _GUARD: _attribute}
        try:
            return bool(eval(self.code, {"__builtins__": _BUILTINS, **names})), None
        except MemoryError:
            raise
        except Exception as error:  # whatever the expression raises
            return False, f"{type(error).__name__}: {error}"


def _start(text: str) -> str:
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."


class _Guarded(ast.NodeTransformer):
    """Lets `_attribute` decide about each attribute that is read."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.ctx, ast.Load):
            return node
        guard = ast.Name(_GUARD, ast.Load())
        return ast.copy_location(ast.Call(guard, [node.value, ast.Constant(node.attr)], []), node)


def _attribute(value: Any, name: str) -> Any:
    """A field, or a method of a plain value or of its type; AttributeError."""
    if isinstance(value, Fields):
        return getattr(value, name)
    kind = value if isinstance(value, type) else type(value)
    if name in _WITHHELD or kind not in (*_PLAIN, type(None)):
        raise AttributeError(_withheld(name, kind.__name__))
    return getattr(value, name)


def _withheld(name: str, owner: str) -> str:
    hint = ": use an f-string" if name.startswith("format") else ""
    return f"'{name}' of '{owner}' is not available here{hint}"


def _check_names(tree: ast.AST) -> None:
    nodes = list(ast.walk(tree))
    for node in nodes:
        found = (getattr(node, field, None) for field in ("attr", "id", "arg"))
        name = next(filter(None, found), None)
        if isinstance(name, str) and name.startswith("_"):
            raise ValueError(f"'{name}' has a leading underscore, which is not allowed here")
        match node:
            case ast.Attribute(value=ast.Constant(value=str()) | ast.Name(id="str"), attr=attr):
                if attr in _WITHHELD:
                    raise ValueError(_withheld(attr, "str"))
    names = [node for node in nodes if isinstance(node, ast.Name)]
    known = {"m", "json", *_BUILTINS} | {n.id for n in names if isinstance(n.ctx, ast.Store)}
    known |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    for used in names:
        if used.id not in known:
            meant = _CONSTANTS.get(used.id.lower(), f"m.{used.id}")
            raise ValueError(
                f"unknown name '{used.id}', did you mean {meant}? "
                "m is the message, and json its data"
            )


@dataclass(frozen=True, slots=True)
class Conditions:
    """Field path -> wanted value, list of possible values, or limits.

    Limits are `min`, `max`, `matches` (a regular expression) and `not`. A path (`pose.x`,
    `poses[0].x`) is looked up in the message, and in the JSON of its string `data`.
    """

    fields: tuple[tuple[str, Any], ...]

    @staticmethod
    def parse(value: object) -> Conditions:
        if not isinstance(value, Mapping) or not value:
            raise ValueError("expected a mapping of fields to values, as in {status: done}")
        for path, wanted in value.items():
            if isinstance(wanted, Mapping):
                check_limits(str(path), wanted)
        return Conditions(tuple((str(path), wanted) for path, wanted in value.items()))

    def holds(self, content: object) -> tuple[bool, str | None]:
        """Whether all hold, and why not."""
        try:
            found = values_at(content, [path for path, _ in self.fields])
        except LookupError as error:
            return False, str(error.args[0])
        for (path, wanted), value in zip(self.fields, found, strict=True):
            if not fits(value, wanted):
                return False, f"{path} is {value!r}"
        return True, None

    @property
    def text(self) -> str:
        """`robot_id == 'robot_1' and status in ['busy']`."""
        return " and ".join(f"{path} {wanted_text(wanted)}" for path, wanted in self.fields)


_MISSING = object()
_LIMITS = ("min", "max", "matches", "not")


def check_limits(path: str, limits: Mapping[Any, Any]) -> None:
    """ValueError for one that there is not, or that is no limit."""
    for name, limit in limits.items():
        if name not in _LIMITS:
            hint = did_you_mean(str(name), _LIMITS) or f"known: {', '.join(_LIMITS)}"
            raise ValueError(f"unknown limit '{name}' of '{path}'; {hint}")
        limit = _number(limit)
        is_number = isinstance(limit, int | float) and not isinstance(limit, bool)
        if name in ("min", "max") and not is_number:
            raise ValueError(f"{name} of '{path}' is not a number: {limit!r}")
        if name == "matches":
            compile_regex(limit)


def compile_regex(value: object) -> re.Pattern[str]:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is not a regular expression: expected a string")
    try:
        return re.compile(value)
    except re.error as error:
        raise ValueError(f"'{value}' is not a regular expression: {error}") from None


def values_at(content: object, paths: Iterable[str]) -> list[Any]:
    """The values at paths in a message, or in the JSON of its string `data`; LookupError."""
    data = json_of(content)
    values = []
    for path in paths:
        found = _look_up(content, path)
        if found is _MISSING and data is not None:
            found = _look_up(data, path)
        if found is _MISSING:
            parts = [part for part in (content, data) if isinstance(part, Mapping | Fields)]
            raise LookupError(_no_field(path, [name for part in parts for name in part]))
        values.append(found)
    return values


def _look_up(content: object, path: str) -> Any:
    for name, index in STEP.findall(path):
        if name:
            if not isinstance(content, Mapping | Fields) or name not in content:
                return _MISSING
            content = content[name]
        else:
            if not isinstance(content, list) or int(index) >= len(content):
                return _MISSING
            content = content[int(index)]
    return content


def fits(found: object, wanted: object) -> bool:
    """Whether a value is the wanted one, one of a list, or within limits."""
    if isinstance(wanted, Mapping):
        return all(_within(found, name, limit) for name, limit in wanted.items())
    if isinstance(wanted, list) and not isinstance(found, list):
        return any(equal(found, one) for one in wanted)
    return equal(found, wanted)


def _within(found: Any, name: str, limit: Any) -> bool:
    if name == "not":
        return not fits(found, limit)
    if name == "matches":
        return isinstance(found, str) and re.search(limit, found) is not None
    if isinstance(found, bool) or not isinstance(found, int | float):
        return False
    limit = _number(limit)
    return bool(found >= limit if name == "min" else found <= limit)


def _number(wanted: object) -> Any:
    """The number of a text that is one, but not for YAML 1.1, which the file is read as: `1e-9`."""
    return float(wanted) if isinstance(wanted, str) and _EXPONENT.fullmatch(wanted) else wanted


def equal(found: object, wanted: object) -> bool:
    """Equality with a tolerance for rounding of numbers; True is not 1."""
    if isinstance(found, bool) or isinstance(wanted, bool):
        return found is wanted
    if isinstance(found, int | float):
        wanted = _number(wanted)
    if isinstance(found, int | float) and isinstance(wanted, int | float):
        return math.isclose(found, wanted, rel_tol=1e-6, abs_tol=1e-12)
    if isinstance(found, list) and isinstance(wanted, list):
        return len(found) == len(wanted) and all(map(equal, found, wanted))
    return bool(found == wanted)


def wanted_text(wanted: object) -> str:
    if isinstance(wanted, Mapping):
        words = {"min": ">=", "max": "<=", "matches": "matches", "not": "is not"}
        return " and ".join(f"{words[name]} {limit!r}" for name, limit in wanted.items())
    return f"in {wanted!r}" if isinstance(wanted, list) else f"== {wanted!r}"
