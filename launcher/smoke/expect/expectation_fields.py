"""Types of the entries of an expectation or a step, besides those of every document."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from launcher.base.document.fields import FieldError, FieldType, nested
from launcher.base.document.quantities import DURATION_PATTERN, parse_duration, quantity
from launcher.smoke.expect.message_conditions import (
    STEP,
    Conditions,
    Expression,
    check_limits,
    compile_regex,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Confirmation:
    """When a violation counts in a watched run: after so many seconds, or so often in a row.

    Exactly one of `for_s` and `times` is given; `text` is the source text.
    """

    text: str
    for_s: float | None = None
    times: int | None = None


def _confirmation(match: re.Match[str]) -> Confirmation:
    if match["times"]:
        return Confirmation(text=match[0], times=int(match["times"]))
    return Confirmation(text=match[0], for_s=parse_duration(match[0]))


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


def regexes(least: int = 1) -> FieldType:
    def parse(value: object) -> tuple[re.Pattern[str], ...]:
        if not isinstance(value, list) or len(value) < least:
            raise FieldError(f"{value!r} is not a list of at least {least} regular expressions")
        return tuple(nested(compile_regex, one, number) for number, one in enumerate(value))

    return FieldType(parse, {"type": "array", "items": {"type": "string"}, "minItems": least})


def _paths(value: object) -> tuple[str, ...]:
    paths = value if isinstance(value, list) and value else [value]
    for path in paths:
        if not isinstance(path, str) or not STEP.match(path):
            raise FieldError(f"invalid field path: {path!r}", hint="as in 'task_id' or 'pose.x'")
    return tuple(paths)


def _number(value: object) -> re.Pattern[str]:
    pattern = compile_regex(value)
    if pattern.groups != 1:
        raise FieldError(
            f"'{value}' has {pattern.groups} groups, and the number is one",
            hint=r"as in 'robot_1: (\d+) tasks'; (?:...) is no group",
        )
    return pattern


CONFIRMATION = quantity(
    "confirmation",
    "2 s or 3 times",
    rf"(?P<times>[1-9][0-9]*) *times?|{DURATION_PATTERN}",
    _confirmation,
)

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

_PATH = {"type": "string", "minLength": 1}


def _wanted(value: object) -> object:
    """A value, several of which one is wanted, or limits."""
    if isinstance(value, Mapping):
        check_limits("is", value)
    return value


WANTED = FieldType(_wanted, {"anyOf": [{"not": {"type": "object"}}, _LIMITS]})
PATHS = FieldType(_paths, {"anyOf": [_PATH, {"type": "array", "items": _PATH, "minItems": 1}]})
NUMBER = FieldType(_number, {"type": "string"})
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
