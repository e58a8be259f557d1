"""Serialized messages (CDR) as values, by the text of their types.

A message is never read beyond its end: a text or a sequence that is longer is an error, and takes
no memory.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

from mcap_ros2 import _dynamic

MAX_DEPTH = 100  # of messages in messages
_HEAD_BYTES = 4
_BYTES = ("byte", "uint8")
# Letters of struct, of which each has the size that it is aligned to.
_NUMBERS = {
    "bool": "?",
    "byte": "B",
    "char": "b",
    "float32": "f",
    "float64": "d",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
_SIZES = {letter: struct.calcsize(f"<{letter}") for letter in _NUMBERS.values()}


class _Cursor:
    """A place in a message; ValueError, struct.error for what is beyond its end."""

    __slots__ = ("data", "offset", "order")

    def __init__(self, data: bytes) -> None:
        if len(data) < _HEAD_BYTES:
            raise ValueError(f"it has {len(data)} bytes only")
        self.data = data
        self.offset = _HEAD_BYTES
        self.order = "<" if data[1] & 1 else ">"

    def number(self, letter: str, size: int) -> Any:
        offset = self.offset + (_HEAD_BYTES - self.offset) % size
        self.offset = offset + size
        return struct.unpack_from(self.order + letter, self.data, offset)[0]

    def numbers(self, letter: str, size: int, count: int) -> list[Any]:
        if not count:
            return []
        offset = self.offset + (_HEAD_BYTES - self.offset) % size
        self._need(offset, size * count, count)
        self.offset = offset + size * count
        return list(struct.unpack_from(f"{self.order}{count}{letter}", self.data, offset))

    def raw(self, count: int) -> bytes:
        start = self.offset
        self._need(start, count, count)
        self.offset = start + count
        return self.data[start : self.offset]

    def length(self) -> int:
        """Of a sequence; each value of it takes a byte at least."""
        count: int = self.number("I", 4)
        self._need(self.offset, count, count)
        return count

    def text(self) -> str:
        count: int = self.number("I", 4)
        if count > len(self.data) - self.offset:
            raise ValueError(f"a text of {count} bytes is longer than the message")
        return self.raw(count)[:-1].decode()  # it ends with a zero byte

    def _need(self, offset: int, size: int, count: int) -> None:
        if size > len(self.data) - offset:
            raise ValueError(f"a sequence of {count} values is longer than the message")


_Read = Callable[[_Cursor], Any]


class _Known(NamedTuple):
    """How a message type is read, and how deep it is nested."""

    read: _Read
    depth: int


def compiled(name: str, text: str, also: str = "") -> Callable[[bytes], Any]:
    """A function from the bytes of a message to an object with its fields as attributes.

    `text` has the definitions of `name` and of all types in it, which may call it `also`. Errors of
    many classes if it cannot be read; the function raises ValueError, struct.error, and
    NotImplementedError for what cannot be decoded.
    """
    read = _CompiledTypes(name, text, also).known(_short(name)).read
    return lambda data: read(_Cursor(data))


def _short(name: str) -> str:
    """`std_msgs/String` of `std_msgs/msg/String`."""
    return f"{name.partition('/')[0]}/{name.rpartition('/')[2]}"


class _CompiledTypes:
    def __init__(self, name: str, text: str, also: str) -> None:
        self._definitions: dict[str, Any] = {
            "builtin_interfaces/Time": _dynamic.TimeDefinition,
            "builtin_interfaces/Duration": _dynamic.TimeDefinition,
        }
        self._known: dict[str, _Known] = {}
        self._open: list[str] = []
        self._classes: dict[str, type] = {}
        _dynamic._for_each_msgdef(name, text, self._define)
        self._definitions.setdefault(_short(also), self._definitions[_short(name)])

    def _define(self, full_name: str, short_name: str, definition: object) -> None:
        self._definitions[short_name] = definition

    def known(self, name: str) -> _Known:
        """ValueError for a type that contains itself, or is nested too deeply."""
        if name in self._open:
            raise ValueError(f"{name} contains itself")
        if name not in self._known:
            self._open.append(name)
            found = self._compile(name)
            self._open.pop()
            if found.depth > MAX_DEPTH:
                raise ValueError(f"it is nested more than {MAX_DEPTH} levels deep")
            self._known[name] = found
        return self._known[name]

    def _compile(self, name: str) -> _Known:
        if len(self._open) > MAX_DEPTH:
            raise ValueError(f"it is nested more than {MAX_DEPTH} levels deep")
        definition = self._definitions.get(name)
        if definition is None:
            return _Known(_failing(ValueError(f"there is no definition of {name}")), 1)
        depth, fields = 1, []
        for field in definition.fields:
            read = _PRIMITIVES.get(field.type.type)
            if not field.type.is_primitive_type():
                inner = self.known(f"{field.type.pkg_name}/{field.type.type}")
                read, depth = inner.read, max(depth, inner.depth + 1)
            elif read is None:
                read = _failing(NotImplementedError(field.type.type))
            fields.append((field.name, _array(field.type, read) if field.type.is_array else read))
        return _Known(_message(_dynamic._message_class(definition, self._classes), fields), depth)


def _failing(error: Exception) -> _Read:
    def read(cursor: _Cursor) -> Any:
        raise error

    return read


def _message(kind: type, fields: list[tuple[str, _Read]]) -> _Read:
    def read(cursor: _Cursor) -> Any:
        found = kind()
        for name, read_field in fields:
            setattr(found, name, read_field(cursor))
        if not fields:
            cursor.raw(1)  # IDL has no empty structure: ROS 2 adds a byte
        return found

    return read


def _array(kind: Any, read: _Read) -> _Read:
    size = kind.array_size if kind.is_fixed_size_array() else None
    letter = _NUMBERS.get(kind.type) if kind.is_primitive_type() else None

    def values(cursor: _Cursor, count: int) -> Any:
        if letter is None:
            return [read(cursor) for _ in range(count)]
        if kind.type in _BYTES:
            return cursor.raw(count)
        return cursor.numbers(letter, _SIZES[letter], count)

    if size is None:
        return lambda cursor: values(cursor, cursor.length())
    return lambda cursor: values(cursor, size)


def _number(letter: str) -> _Read:
    size = _SIZES[letter]
    return lambda cursor: cursor.number(letter, size)


_PRIMITIVES: dict[str, _Read] = {
    "string": _Cursor.text,
    **{name: _number(letter) for name, letter in _NUMBERS.items()},
}
