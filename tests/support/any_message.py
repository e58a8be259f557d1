"""Any message: hypothesis strategies for values of every field of a message class."""

from __future__ import annotations

import math
import sys
from typing import Any

from hypothesis import strategies as st
from rosidl_parser import definition

from launcher.ros.messages.from_yaml import LIMITS
from launcher.ros.messages.interfaces import class_of

# what DDS and the wire can carry: no lone surrogates, no NUL
LETTERS = st.characters(exclude_categories=("Cs",), exclude_characters="\0")
# YAML carries every float64 exactly; float32 fields are given values that they hold exactly
FLOATS = st.floats(width=32, allow_nan=True)
LARGEST = {"float": (2 - 2**-23) * 2.0**127, "double": sys.float_info.max}
LONG = 300  # elements of a sequence without a bound


def text(most: int) -> st.SearchStrategy[str]:
    return st.text(LETTERS, max_size=most)


def values_of(kind: Any) -> st.SearchStrategy[Any]:
    if isinstance(kind, definition.Array):
        return st.lists(values_of(kind.value_type), min_size=kind.size, max_size=kind.size)
    if isinstance(kind, definition.AbstractSequence):
        most = min(3, getattr(kind, "maximum_size", 3))
        return st.lists(values_of(kind.value_type), max_size=most)
    if isinstance(kind, definition.NamespacedType):
        return messages(class_of(*kind.namespaced_name()))
    if isinstance(kind, definition.AbstractGenericString):
        return text(min(8, getattr(kind, "maximum_size", None) or 8))
    return basic_values(kind.typename)


def basic_values(name: str) -> st.SearchStrategy[Any]:
    if name == "boolean":
        return st.booleans()
    if name == "octet":
        return st.binary(min_size=1, max_size=1)
    if name == "char":  # of IDL; in .msg files `char` is uint8
        return st.characters(max_codepoint=127, exclude_characters="\0")
    if name in ("float", "double"):
        return FLOATS
    return st.integers(*LIMITS[name])


@st.composite
def messages(draw: st.DrawFn, cls: Any) -> Any:
    message = cls()
    for name, kind in zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True):
        setattr(message, name, draw(values_of(kind)))
    return message


def same(one: Any, other: Any) -> bool:
    if isinstance(one, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def has(whole: object, part: object) -> bool:
    """Whether all values in `part` are the same in `whole`."""
    if isinstance(part, dict) and isinstance(whole, dict):
        return all(name in whole and has(whole[name], value) for name, value in part.items())
    if isinstance(part, list) and isinstance(whole, list):
        return len(part) == len(whole) and all(map(has, whole, part))
    return whole == part


def extreme(cls: Any, *, high: bool) -> Any:
    """A message with the largest values and lengths, or with the smallest."""
    message = cls()
    for name, kind in zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True):
        setattr(message, name, _extreme_value(kind, high))
    return message


def _extreme_value(kind: Any, high: bool) -> Any:
    if isinstance(kind, definition.AbstractNestedType):
        is_array = isinstance(kind, definition.Array)
        length = kind.size if is_array else high * getattr(kind, "maximum_size", LONG)
        return [_extreme_value(kind.value_type, high)] * length
    if isinstance(kind, definition.NamespacedType):
        return extreme(class_of(*kind.namespaced_name()), high=high)
    if isinstance(kind, definition.AbstractGenericString):
        return "ü" * (high * (getattr(kind, "maximum_size", None) or LONG))
    name = kind.typename
    if name == "boolean":
        return high
    if name == "octet":
        return b"\xff" if high else b"\0"
    if name == "char":
        return "\x7f" if high else "\x01"
    if name in ("float", "double"):
        return LARGEST[name] * (1 if high else -1)
    return LIMITS[name][high]
