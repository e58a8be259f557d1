"""Types of the entries of an expectation or a step: each parses a value and has a JSON Schema."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.smoke.expect.conditions import Conditions, Expression, compile_regex
from launcher.text import did_you_mean


class FieldError(ValueError):
    """An invalid value; `path` are the keys from the value to the place of the mistake.

    `key`: the last key itself is wrong, not its value. `all`: several mistakes in one value.
    """

    def __init__(
        self,
        message: str,
        path: tuple[object, ...] = (),
        hint: str | None = None,
        *,
        key: bool = False,
    ) -> None:
        super().__init__(message)
        self.path = path
        self.hint = hint
        self.key = key
        self.all: tuple[FieldError, ...] = (self,)


@dataclass(frozen=True, slots=True)
class FieldType:
    """`parse` turns a value of YAML into what the judges take; ValueError if it is invalid."""

    parse: Callable[[object], Any]
    schema: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Field:
    name: str
    type: FieldType
    doc: str
    required: bool = False


def near(word: object, known: Collection[str]) -> str | None:
    """`did you mean 'node'?`, or all known words."""
    listed = f"known: {', '.join(known)}" if known else None
    return did_you_mean(str(word), known) or listed


def text(noun: str = "text") -> FieldType:
    def parse(value: object) -> str:
        if not isinstance(value, str) or not value:
            raise FieldError(f"{value!r} is not a {noun}: expected a non-empty string")
        return value

    return FieldType(parse, {"type": "string", "minLength": 1})


def name(noun: str, *, wildcards: bool = False) -> FieldType:
    """A full name in the ROS graph; with `wildcards` also a pattern of such names."""
    pattern = r"[/*?\[][^ ]*" if wildcards else r"/[^ ]*"

    def parse(value: object) -> str:
        if not isinstance(value, str) or re.fullmatch(pattern, value) is None:
            hint = f"full names begin with '/': /{value}" if isinstance(value, str) else None
            raise FieldError(f"invalid {noun} name: {value!r}", hint=hint)
        return value

    return FieldType(parse, {"type": "string", "pattern": f"^{pattern}$"})


def type_name(kind: str, example: str) -> FieldType:
    """The full name of an interface; `std_msgs/String` is short for `std_msgs/msg/String`."""
    pattern = r"[A-Za-z][A-Za-z0-9_]*(?:/[a-z]+)?/[A-Za-z][A-Za-z0-9_]*"

    def parse(value: object) -> str:
        if not isinstance(value, str) or re.fullmatch(pattern, value) is None:
            raise FieldError(f"invalid type {value!r}: expected a name such as {example}")
        package, *_, last = value.split("/")
        return f"{package}/{kind}/{last}" if value.count("/") == 1 else value

    return FieldType(parse, {"type": "string", "pattern": f"^{pattern}$"})


def choice(*words: str) -> FieldType:
    known = list(words)

    def parse(value: object) -> str:
        if value not in known:
            raise FieldError(f"{value!r} is not one of {', '.join(known)}", hint=near(value, known))
        return str(value)

    return FieldType(parse, {"enum": known})


def instance(kind: type, noun: str, schema: Mapping[str, object]) -> FieldType:
    """Any value of a class, as it is; `True` is not an integer."""

    def parse(value: object) -> object:
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise FieldError(f"{value!r} is not {noun}")
        return value

    return FieldType(parse, schema)


def regexes(least: int = 1) -> FieldType:
    def parse(value: object) -> tuple[re.Pattern[str], ...]:
        if not isinstance(value, list) or len(value) < least:
            raise FieldError(f"{value!r} is not a list of at least {least} regular expressions")
        return tuple(_nested(compile_regex, one, number) for number, one in enumerate(value))

    return FieldType(parse, {"type": "array", "items": {"type": "string"}, "minItems": least})


def _nested(parse: Callable[[object], Any], value: object, *path: object) -> Any:
    try:
        return parse(value)
    except ValueError as error:
        raise FieldError(str(error), path, getattr(error, "hint", None)) from None


def record(noun: str, **entries: FieldType) -> FieldType:
    """A mapping with known keys."""

    def parse(value: object) -> dict[str, Any]:
        if not isinstance(value, Mapping) or not value:
            raise FieldError(f"{noun}: expected a mapping with {', '.join(entries)}")
        found: dict[str, Any] = {}
        errors: list[FieldError] = []
        for key, one in value.items():
            if key not in entries:
                hint = near(key, entries)
                errors.append(FieldError(f"{noun} has no '{key}'", (key,), hint, key=True))
                continue
            try:
                found[str(key)] = _nested(entries[key].parse, one, key)
            except FieldError as error:
                errors.append(error)
        if errors:
            errors[0].all = tuple(errors)
            raise errors[0]
        return found

    schema: dict[str, object] = {
        "type": "object",
        "properties": {key: entry.schema for key, entry in entries.items()},
        "additionalProperties": False,
        "minProperties": 1,
    }
    return FieldType(parse, schema)


_LIMITS = {
    "type": "object",
    "properties": {
        "min": {"type": "number"},
        "max": {"type": "number"},
        "matches": {"type": "string"},
        "not": {},
    },
    "additionalProperties": False,
}

ANYTHING = FieldType(lambda value: value, {})
FLAG = instance(bool, "true or false", {"type": "boolean"})
INTEGER = instance(int, "an integer", {"type": "integer"})
MAPPING = instance(Mapping, "a mapping such as {data: hello}", {"type": "object"})
REGEX = FieldType(compile_regex, {"type": "string"})
EXPRESSION = FieldType(Expression.parse, {"type": "string", "minLength": 1})
CONDITIONS = FieldType(
    Conditions.parse,
    {
        "type": "object",
        "minProperties": 1,
        "additionalProperties": {"anyOf": [{"not": {"type": "object"}}, _LIMITS]},
    },
)
