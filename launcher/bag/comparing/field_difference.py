"""The first field in which two messages differ."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, NamedTuple

from launcher.bag.decode import fields_of, is_list, is_message

_INDEX = re.compile(r"\[\d+\]")
_HEADERS = ("std_msgs/Header", "std_msgs/msg/Header")
ABSENT = "(no such field)"


class FieldDifference(NamedTuple):
    path: str
    a: Any
    b: Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """What is alike: numbers within the tolerances, and all that is ignored.

    A path in `ignored` without an index means all elements: `poses.position`, `poses[3].position`.
    `stamps` ignores the stamps of headers.
    """

    absolute: float = 0.0
    relative: float = 0.0
    ignored: Collection[str] = ()
    stamps: bool = False

    def ignores(self, path: str, parent: object, name: str) -> bool:
        if self.stamps and name == "stamp" and getattr(type(parent), "_type", "") in _HEADERS:
            return True
        return bool(self.ignored) and (path in self.ignored or _INDEX.sub("", path) in self.ignored)

    def alike(self, a: float, b: float) -> bool:
        if a == b or (math.isnan(a) and math.isnan(b)):
            return True
        if not (math.isfinite(a) and math.isfinite(b)):
            return False
        return abs(a - b) <= max(self.absolute, self.relative * max(abs(a), abs(b)))


def first_difference(a: Any, b: Any, rules: Rules, path: str = "") -> FieldDifference | None:
    """Between decoded messages; None if they are alike."""
    if is_message(a) and is_message(b):
        return _of_messages(a, b, rules, path)
    if is_list(a) and is_list(b):
        return _of_lists(a, b, rules, path)
    if _is_number(a) and _is_number(b):
        return None if rules.alike(a, b) else FieldDifference(path, a, b)
    return None if a == b and is_message(a) == is_message(b) else FieldDifference(path, a, b)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _of_messages(a: object, b: object, rules: Rules, path: str) -> FieldDifference | None:
    for name in dict.fromkeys((*fields_of(a), *fields_of(b))):
        full = f"{path}.{name}" if path else name
        if rules.ignores(full, a, name):
            continue
        if name not in fields_of(a) or name not in fields_of(b):
            known = name in fields_of(a)
            own = getattr(a if known else b, name)
            return FieldDifference(full, own if known else ABSENT, ABSENT if known else own)
        if found := first_difference(getattr(a, name), getattr(b, name), rules, full):
            return found
    return None


def _of_lists(a: Any, b: Any, rules: Rules, path: str) -> FieldDifference | None:
    if type(a) is bytes and a == b:
        return None
    for index, (one, other) in enumerate(zip(a, b, strict=False)):
        full = f"{path}[{index}]"
        if full not in rules.ignored and (found := first_difference(one, other, rules, full)):
            return found
    if len(a) != len(b):
        return FieldDifference(f"the length of {path}", len(a), len(b))
    return None
