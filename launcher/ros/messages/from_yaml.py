"""Fills a message from YAML, and refuses values that do not fit."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import yaml
from rosidl_parser import definition

from launcher.base import yaml_bounds
from launcher.base.ros_errors import VerbError
from launcher.base.text import did_you_mean
from launcher.ros.messages.classes import class_of

FLOATS = {"float", "double", "long double"}
LIMITS: dict[str, tuple[int, int]] = {
    f"{sign}int{bits}": (0 if sign else -(2 ** (bits - 1)), 2 ** (bits - (0 if sign else 1)) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}

Stamp = Callable[[Any], None]
_MARKER = re.compile(r"---(\s|$)")  # the first line of a document


class Content(NamedTuple):
    """A message, and what sets its `now` fields."""

    message: Any
    stamps: list[Stamp]

    def stamp(self, now_ns: int) -> None:
        """Set the `now` fields to this time."""
        if self.stamps:
            now = class_of("builtin_interfaces", "msg", "Time")(
                sec=now_ns // 1_000_000_000, nanosec=now_ns % 1_000_000_000
            )
            stamp_all(self.stamps, now)


def parse(text: str) -> dict[str, Any]:
    """The fields of a YAML text; none for an empty one. VerbError with line and column."""
    try:
        values = value_of(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = getattr(error, "problem", None) or str(error)
        raise VerbError(f"The passed value is not YAML: {problem}{place}") from None
    if values is None or values == "":
        return {}
    if not isinstance(values, dict):
        raise VerbError(
            "The passed value needs to be a dictionary in YAML format",
            hint=f"got {_named(values)}; write \"field: value\" or '{{field: value}}'",
        )
    return values


def fill(message: Any, values: dict[str, Any]) -> list[Stamp]:
    """Set the fields; VerbError that names the field. Returns what sets the `now` fields."""
    stamps: list[Stamp] = []
    _fill(message, values, "", stamps)
    return stamps


def stamp_all(stamps: Iterable[Stamp], now: Any) -> None:
    """Set the `auto` and `now` fields to this time, a message."""
    for stamp in stamps:
        stamp(now)


def documents(path: str) -> Iterator[str]:
    """The documents of a YAML file between lines of `---`, as `topic echo` prints them.

    Those without an entry are left out. VerbError.
    """
    lines: list[str] = []
    try:
        with open(path, encoding="utf-8") as file:
            for line in itertools.chain(file, ["---"]):
                if not _MARKER.match(line):
                    lines.append(line)
                    continue
                if any(one.strip() and not one.startswith("#") for one in lines):
                    yield "".join(lines)
                lines = [line[3:]]
    except OSError as error:
        raise VerbError(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise VerbError(f"{path}: not UTF-8") from None


def _fill(message: Any, values: object, path: str, stamps: list[Stamp]) -> None:
    if not isinstance(values, dict):
        raise _misfit(path.rstrip("."), f"the fields of {type(message).__name__}", values)
    kinds = dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))
    for name, value in values.items():
        if name not in kinds:
            raise _unknown(message, name, list(kinds))
        setattr(message, name, _convert(value, kinds[name], f"{path}{name}", stamps))


def _convert(value: Any, kind: Any, path: str, stamps: list[Stamp]) -> Any:
    if isinstance(kind, definition.AbstractNestedType):
        return _sequence(value, kind, path, stamps)
    if isinstance(kind, definition.NamespacedType):
        return _message(value, kind, path, stamps)
    if isinstance(kind, definition.AbstractGenericString):
        return _string(value, kind, path)
    return _basic(value, kind.typename, path)


def _message(value: object, kind: Any, path: str, stamps: list[Stamp]) -> Any:
    package, folder, name = kind.namespaced_name()
    message = class_of(package, folder, name)()
    if value == "auto" and (package, name) == ("std_msgs", "Header"):
        stamps.append(lambda now: setattr(message, "stamp", now))
    elif value == "now" and (package, name) == ("builtin_interfaces", "Time"):
        stamps.append(lambda now: _set_time(message, now))
    else:
        _fill(message, value, f"{path}.", stamps)
    return message


def _set_time(message: Any, now: Any) -> None:
    message.sec, message.nanosec = now.sec, now.nanosec


def _sequence(values: Any, kind: Any, path: str, stamps: list[Stamp]) -> list[Any]:
    if isinstance(values, bytes):
        values = _bytes(values, kind.value_type, path)
    if not isinstance(values, list | tuple):
        raise _misfit(path, "a list", values)
    if isinstance(kind, definition.Array) and len(values) != kind.size:
        raise _misfit(path, f"a list of {kind.size} values", values)
    if isinstance(kind, definition.BoundedSequence) and len(values) > kind.maximum_size:
        raise _misfit(path, f"a list of at most {kind.maximum_size} values", values)
    return [
        _convert(value, kind.value_type, f"{path}[{index}]", stamps)
        for index, value in enumerate(values)
    ]


def _bytes(values: bytes, kind: object, path: str) -> list[Any]:
    """The items of an array of bytes that is written as `!!binary`."""
    name = getattr(kind, "typename", "")
    if name == "octet":
        return [bytes([value]) for value in values]
    if name == "int8":
        return [value - 256 if value > 127 else value for value in values]
    if name == "uint8":
        return list(values)
    raise _misfit(path, "a list", values)


def _string(value: object, kind: object, path: str) -> str:
    # `data: 5` is a string where the field is one, as with ros2cli
    if not isinstance(value, str | bool | int | float):
        raise _misfit(path, "a string", value)
    try:
        text = str(value)
        text.encode()
    except ValueError:  # a number of thousands of digits, or no characters
        raise _misfit(path, "a string", value) from None
    limit = getattr(kind, "maximum_size", None)
    if limit is not None and len(text) > limit:
        raise _misfit(path, f"a string of at most {limit} characters", value)
    return text


def _basic(value: object, name: str, path: str) -> Any:
    if name == "boolean":
        if isinstance(value, bool):
            return value
        raise _misfit(path, "true or false", value)
    if name == "octet":
        return _octet(value, path)
    if name == "char":  # of IDL; in .msg files `char` is uint8
        return _letter(value, path)
    if name in FLOATS:
        return _float(value, path)
    low, high = LIMITS.get(name, LIMITS["uint8"])
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise _misfit(path, f"a whole number from {low} to {high}", value)
    return value


def _float(value: object, path: str) -> float:
    if isinstance(value, int | float | str) and not isinstance(value, bool):
        try:
            return float(value)  # YAML takes 1e-3 for a string
        except (ValueError, OverflowError):
            pass
    raise _misfit(path, "a number", value)


def _octet(value: object, path: str) -> bytes:
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 255:
        return bytes([value])
    if isinstance(value, str) and len(value) == 1 and ord(value) <= 255:
        return value.encode("latin-1")
    if isinstance(value, bytes) and len(value) == 1:
        return value
    raise _misfit(path, "one byte (a number from 0 to 255 or one character)", value)


def _letter(value: object, path: str) -> str:
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 9:
        value = str(value)  # a digit without quotes
    if isinstance(value, str) and len(value) == 1 and value.isascii():
        return value
    raise _misfit(path, "one ASCII character", value)


def _misfit(path: str, expected: str, value: object) -> VerbError:
    return VerbError(f"Failed to populate field: '{path}' takes {expected}, got {_named(value)}")


def _unknown(message: Any, name: object, fields: list[str]) -> VerbError:
    from launcher.ros.messages.interfaces import note_of_change

    owner = type(message).__name__
    package, kind, *_ = type(message).__module__.split(".")
    note = note_of_change(f"{package}/{kind}/{owner.partition('_')[0]}")
    hint = did_you_mean(str(name), fields) or f"fields of {owner}: {', '.join(fields)}"
    return VerbError(
        f"Failed to populate field: '{owner}' object has no attribute '{name}'",
        hint=f"{hint}\n{note}" if note else hint,
    )


_WORDS = {
    bool: "boolean",
    int: "number",
    float: "number",
    str: "string",
    bytes: "!!binary",
    dict: "mapping",
}


def _named(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return f"{shown(value)} ({_WORDS.get(type(value), type(value).__name__)})"


_LOADER: object = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
TEXTS: object = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


def value_of(text: str, loader: object = None) -> Any:
    """The value of a YAML text, None if it is empty; raises yaml.YAMLError only.

    `loader`: TEXTS takes every word for a text.
    """
    return yaml_bounds.load(text, loader)


def shown(value: object, most: int = 60) -> str:
    """`repr`, cut; `repr(int)` raises ValueError past the digit limit."""
    try:
        text = repr(value)
    except ValueError:
        return "a number of thousands of digits"
    return text if len(text) <= most else text[: most - 3] + "..."
