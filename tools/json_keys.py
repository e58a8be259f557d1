"""The keys of JSON objects, as `json_forms` writes them, and where an object differs from them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple


class Key(NamedTuple):
    """A key of an object: `kind` is empty or one of `[] {} *`, `inner` are the keys below it."""

    name: str
    is_optional: bool
    kind: str
    inner: tuple[Key, ...]


_KEY = re.compile(r"\s*(\w+)(\??)")
_PAIRS = {"[": "]", "{": "}"}


def keys_in(text: str) -> tuple[Key, ...]:
    """The keys that a text describes; ValueError."""
    keys, rest = _keys(text)
    if rest:
        raise ValueError(f"unexpected {rest[:20]!r}")
    return keys


def _keys(text: str) -> tuple[tuple[Key, ...], str]:
    found = []
    while (match := _KEY.match(text)) is not None:
        rest, kind, inner = text[match.end() :], "", ()
        if rest[:1] == "*":
            kind, rest = "*", rest[1:]
        elif rest[:1] in _PAIRS:
            end = _PAIRS[rest[0]]
            kind = rest[0] + end
            inner, rest = _keys(rest[1:])
            if rest[:1] != end:
                raise ValueError(f"no {end!r} in front of {rest[:20]!r}")
            rest = rest[1:]
        found.append(Key(match[1], bool(match[2]), kind, inner))
        if rest[:1] != ",":
            return tuple(found), rest
        text = rest[1:]
    return tuple(found), text


def faults_of(value: object, keys: tuple[Key, ...], place: str = "") -> Iterator[str]:
    """Where an object has other keys than these, or values of another kind."""
    if not isinstance(value, Mapping):
        yield f"{place or 'the answer'} is no object"
        return
    known = {key.name: key for key in keys}
    yield from (f"{place}.{name} is not in the table" for name in value if name not in known)
    for name, key in known.items():
        if name in value:
            yield from _value_faults(value[name], key, f"{place}.{name}")
        elif not key.is_optional:
            yield f"{place}.{name} is missing"


def _value_faults(value: object, key: Key, place: str) -> Iterator[str]:
    if value is None or key.kind == "*":
        return
    expected = {"": (str, int, float), "[]": list, "{}": dict}[key.kind]
    if not isinstance(value, expected):
        yield f"{place} is {type(value).__name__}"
    elif isinstance(value, list):
        for number, one in enumerate(value):
            if key.inner:
                yield from faults_of(one, key.inner, f"{place}[{number}]")
            elif isinstance(one, (list, dict)):
                yield f"{place}[{number}] is {type(one).__name__}"
    elif isinstance(value, dict) and key.inner:
        yield from faults_of(value, key.inner, place)
