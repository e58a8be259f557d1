"""A message as plain values, YAML, CSV or JSON, formatted like `ros2 topic echo`.

PyYAML makes a node and several events of each number, so long arrays are written without it: a
token stands for the array while PyYAML writes the rest. An image of 300 kB takes 0.01 s of CPU
this way instead of 2.9 s and 89 MB.
"""

from __future__ import annotations

import array
import itertools
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import yaml
from rosidl_parser import definition

from launcher.base.yaml_dumper import Dumper

_SEQUENCES = (list, tuple, array.array)
LONG = 1024  # numbers; a shorter array goes through PyYAML
_PIECE = 65536
_BYTES = [str(number) for number in range(256)]
_SPECIAL = {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}
# random, so that no text of a message is taken for an array
_PREFIX = f"array-{os.urandom(12).hex()}-"
_TOKEN = re.compile(f"{_PREFIX}(\\d+)-")
_LEAD = re.compile(r"(?:- | )*")


class LongArray:
    """An array of numbers, and what follows the last of them."""

    _numbers = itertools.count()

    def __init__(self, values: object, more: list[str]) -> None:
        self.values = values
        self._more = more
        self.token = f"{_PREFIX}{next(self._numbers)}-"

    def pieces(self, separator: str) -> Iterator[str]:
        """The numbers in YAML, each after a separator."""
        for piece in _pieces(self.values, _yaml_words):
            yield separator + separator.join(piece)
        for word in self._more:
            yield separator + word


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How a message is shown; `length` cuts strings, bytes and arrays, None cuts nothing."""

    length: int | None = None
    no_arr: bool = False
    no_str: bool = False
    flow: bool = False
    # token -> long array that is written without PyYAML
    aside: dict[str, LongArray] | None = None


WHOLE = Style()


class _MessageDumper(Dumper):
    """Has separate representers."""


def _block(dumper: yaml.SafeDumper, mapping: dict[Any, Any]) -> yaml.MappingNode:
    """As in rosidl_runtime_py, a block in flow style, too, unless it is in a list."""
    node = dumper.represent_dict(mapping)
    node.flow_style = None
    return node


_MessageDumper.add_representer(dict, _block)
_MessageDumper.add_representer(LongArray, lambda dumper, array: dumper.represent_str(array.token))


def to_yaml(message: Any, style: Style = WHOLE) -> str:
    return "".join(yaml_pieces(message, style))


def yaml_pieces(message: Any, style: Style = WHOLE) -> Iterator[str]:
    """A YAML document, in pieces not much longer than the message without arrays."""
    arrays: dict[str, LongArray] = {}
    text = dump(to_plain(message, replace(style, aside=arrays)), flow=style.flow)
    return with_arrays(text, arrays, flow=style.flow)


def dump(plain: object, *, flow: bool = False, sort: bool = False) -> str:
    """Plain values as YAML, one line per value however long."""
    text: str = yaml.dump(
        plain,
        Dumper=_MessageDumper,
        allow_unicode=True,
        width=sys.maxsize,
        default_flow_style=flow,
        sort_keys=sort,
    )
    return text


def to_plain(message: Any, style: Style = WHOLE) -> dict[str, Any]:
    """A message as nested dicts in the order of its definition."""
    fields = zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True)
    return {name: _plain(getattr(message, name), kind, style) for name, kind in fields}


def _plain(value: Any, kind: object, style: Style) -> Any:
    if isinstance(value, bool | int | float):
        return value
    if isinstance(value, bytes):
        return _cut(value.decode("latin-1"), style.length)
    if isinstance(value, str):
        if style.no_str:
            return f"<string length: <{len(value)}>>"
        return _cut(value, style.length)
    if is_list(value):
        return _plain_sequence(value, kind, style)
    return value.item() if _is_of_numpy(value) else to_plain(value, style)


def is_list(value: object) -> bool:
    return isinstance(value, _SEQUENCES) or _is_array(value)


def _is_array(value: object) -> bool:
    return _is_of_numpy(value) and hasattr(value, "__len__")


def _is_of_numpy(value: object) -> bool:
    # importing numpy is slow, so it is loaded only by types that have an array of it
    return type(value).__module__ == "numpy"


def _plain_sequence(values: Any, kind: Any, style: Style) -> Any:
    if style.no_arr and kind is not None:
        return _shape(values, kind)
    shown = values if style.length is None else values[: style.length]
    if isinstance(shown, array.array) or _is_array(shown):
        if style.aside is not None and len(shown) >= LONG:
            held = LongArray(shown, ["'...'"] if len(shown) < len(values) else [])
            style.aside[held.token] = held
            return held
        plain = shown.tolist()  # a hundred times faster than value by value
    else:
        plain = [_plain(value, None, style) for value in shown]
    return plain if len(shown) == len(values) else [*plain, "..."]


def _cut(text: str, length: int | None) -> str:
    return text if length is None or len(text) <= length else text[:length] + "..."


def _shape(values: Any, kind: Any) -> str:
    name = kind_name(kind.value_type)
    if isinstance(kind, definition.Array):
        return f"<array type: {name}[{kind.size}]>"
    if isinstance(kind, definition.BoundedSequence):
        name = f"{name}[{kind.maximum_size}]"
    return f"<sequence type: {name}, length: {len(values)}>"


def kind_name(kind: Any) -> str:
    if isinstance(kind, definition.AbstractString):
        return "string"
    if isinstance(kind, definition.AbstractWString):
        return "wstring"
    if isinstance(kind, definition.NamespacedType):
        return "/".join(kind.namespaced_name())
    return str(kind.typename)


def to_csv(message: Any, style: Style = WHOLE) -> str:
    fields = zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True)
    return ",".join(_csv(getattr(message, name), kind, style) for name, kind in fields)


def _csv(value: object, kind: object, style: Style) -> str:
    if is_list(value):
        if style.no_arr and kind is not None:
            return _shape(value, kind)
        return ",".join(_csv_items(value, style))
    if isinstance(value, str) and style.no_str:
        return f"<string length: <{len(value)}>>"
    if isinstance(value, str):
        return _cut(value, style.length)
    if isinstance(value, bytes):
        return str(value)  # octets are single, so there is nothing to cut
    if isinstance(value, bool | int | float) or _is_of_numpy(value):
        return str(value)
    return to_csv(value, style)


def _csv_items(values: Any, style: Style) -> Iterator[str]:
    if isinstance(values, array.array) and style.length is None and values:
        yield csv_text(values)
        return
    for index, value in enumerate(values):
        if style.length is not None and index >= style.length:
            yield "..."
            return
        yield _csv(value, None, style)


def csv_text(values: object) -> str:
    """The numbers between commas, as Python writes them."""
    return ",".join(",".join(piece) for piece in _pieces(values, _words))


def _pieces(values: Any, words: Any) -> Iterator[Iterator[str]]:
    for start in range(0, len(values), _PIECE):
        yield words(values[start : start + _PIECE])


def _words(values: Any) -> Iterator[str]:
    if getattr(values, "typecode", None) == "B":
        return map(_BYTES.__getitem__, values)
    return map(str, values.tolist())


def _yaml_words(values: Any) -> Iterator[str]:
    is_float = values.typecode in "fd" if hasattr(values, "typecode") else values.dtype.kind == "f"
    return map(_float_word, values.tolist()) if is_float else _words(values)


def _float_word(value: float) -> str:
    word = repr(value)
    if word in _SPECIAL:
        return _SPECIAL[word]
    # without a dot it would be read as a string
    return word.replace("e", ".0e", 1) if "e" in word and "." not in word else word


def with_arrays(text: str, arrays: dict[str, LongArray], *, flow: bool) -> Iterator[str]:
    """YAML with the arrays in place of their tokens."""
    end = 0
    for match in _TOKEN.finditer(text):
        array = arrays[match[0]]
        if flow:
            yield text[end : match.start()] + "["
            pieces = array.pieces(", ")
            yield next(pieces)[2:]
            yield from pieces
            yield "]"
        else:
            yield text[end : match.start() - 1]  # the blank behind the name of the field
            yield from array.pieces(f"\n{_indent(text, match.start())}- ")
        end = match.end()
    yield text[end:]


def _indent(text: str, place: int) -> str:
    """Blanks up to the column of the field."""
    lead = _LEAD.match(text, text.rfind("\n", 0, place) + 1)
    return " " * (len(lead[0]) if lead else 0)
