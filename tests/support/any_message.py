"""Any message: hypothesis strategies for values of every field of a message class."""

from __future__ import annotations

import importlib
import math
from typing import Any

from hypothesis import strategies as st
from rosidl_parser import definition

from launcher.ros.messages.from_yaml import _LIMITS

# what DDS and the wire can carry: no lone surrogates, no NUL
LETTERS = st.characters(exclude_categories=("Cs",), exclude_characters="\0")
# YAML carries every float64 exactly; float32 fields are given values that they hold exactly
FLOATS = st.floats(width=32, allow_nan=True)


def text(most: int) -> st.SearchStrategy[str]:
    return st.text(LETTERS, max_size=most)


def values_of(kind: Any) -> st.SearchStrategy[Any]:
    if isinstance(kind, definition.Array):
        return st.lists(values_of(kind.value_type), min_size=kind.size, max_size=kind.size)
    if isinstance(kind, definition.AbstractSequence):
        most = min(3, getattr(kind, "maximum_size", 3))
        return st.lists(values_of(kind.value_type), max_size=most)
    if isinstance(kind, definition.NamespacedType):
        package, *folders, name = kind.namespaced_name()
        return messages(getattr(importlib.import_module(".".join([package, *folders])), name))
    if isinstance(kind, definition.AbstractGenericString):
        return text(min(8, getattr(kind, "maximum_size", None) or 8))
    return basic_values(kind.typename)


def basic_values(name: str) -> st.SearchStrategy[Any]:
    if name == "boolean":
        return st.booleans()
    if name == "octet":
        return st.binary(min_size=1, max_size=1)
    if name in ("float", "double"):
        return FLOATS
    return st.integers(*_LIMITS[name])


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
