"""Reads fields of JSON objects; what has a wrong type is as if it were missing, and is noted."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from launcher.base.model.event_entries import is_time
from launcher.faults.incident.limits import clipped

MAX_TEXT = 4000  # characters
MAX_NAME = 300
_MOST_PROBLEMS = 50
_NOTHING: Mapping[str, Any] = {}


class DocumentFields:
    """The fields of one object. `place` names it in `problems`."""

    def __init__(self, value: object, place: str, problems: list[str]) -> None:
        self.place = place
        self.problems = problems
        self.value: Mapping[str, Any] = value if isinstance(value, Mapping) else _NOTHING
        if not isinstance(value, Mapping):
            self._wrong("", value, "an object")

    def text(self, key: str) -> str:
        return self.optional(key) or ""

    def optional(self, key: str) -> str | None:
        value = self.value.get(key)
        if value is None or isinstance(value, str):
            return value if value is None else clipped(value, MAX_TEXT)
        self._wrong(key, value, "a text")
        return str(value) if isinstance(value, (int, float)) else None

    def whole(self, key: str, default: int) -> int:
        value = self.value.get(key)
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        if value is not None:
            self._wrong(key, value, "a whole number")
        return default

    def time(self, key: str) -> float | None:
        """Seconds since 1970."""
        value = self.value.get(key)
        if value is None or is_time(value):
            return None if value is None else float(value)
        self._wrong(key, value, "a time in seconds since 1970")
        return None

    def mapping(self, key: str) -> Mapping[str, Any]:
        value = self.value.get(key)
        if value is not None and not isinstance(value, Mapping):
            self._wrong(key, value, "an object")
        return value if isinstance(value, Mapping) else _NOTHING

    def items(self, key: str, most: int) -> list[Any]:
        """The items of a list, of a longer one the last `most`."""
        value = self.value.get(key)
        if value is None:
            return []
        if not isinstance(value, list):
            self._wrong(key, value, "a list")
            return []
        if len(value) > most:
            self._note(f"{self._named(key)}: the last {most} of {len(value)} are shown")
        return value[-most:]

    def texts(self, key: str, most: int = 200) -> tuple[str, ...]:
        found = self.items(key, most)
        if not all(isinstance(one, str) for one in found):
            self._wrong(key, found, "a list of texts")
        return tuple(clipped(one, MAX_TEXT) for one in found if isinstance(one, str))

    def objects(self, key: str, most: int) -> Iterator[DocumentFields]:
        for number, one in enumerate(self.items(key, most)):
            place = f"{self._named(key)}[{number}]"
            if isinstance(one, Mapping):
                yield DocumentFields(one, place, self.problems)
            else:
                self._note(f"{place}: {_short(one)} is not an object")

    def children(self, key: str) -> Iterator[tuple[str, DocumentFields]]:
        """The objects of an object, by their names."""
        for name, one in self.mapping(key).items():
            yield (
                str(name)[:MAX_NAME],
                DocumentFields(one, f"{self._named(key)}[{name}]", self.problems),
            )

    def times(self, key: str, most: int) -> tuple[float, ...]:
        """Times, sorted."""
        found = self.items(key, most)
        known = [float(one) for one in found if is_time(one)]
        if len(known) < len(found):
            self._note(f"{self._named(key)}: {len(found) - len(known)} items are no times")
        return tuple(sorted(known))

    def points(self, key: str, width: int, most: int) -> tuple[tuple[float, ...], ...]:
        """Rows of numbers, a time first, in their order; NaN for a number that is unknown."""
        found = self.items(key, most)
        rows = [_row(one, width) for one in found]
        known = [row for row in rows if row is not None]
        if len(known) < len(found):
            lost = len(found) - len(known)
            self._note(f"{self._named(key)}: {lost} items are no rows of {width} numbers")
        return tuple(sorted(known, key=lambda row: row[0]))

    def _named(self, key: str) -> str:
        return ".".join(filter(None, [self.place, key])) or "the document"

    def _wrong(self, key: str, value: object, wanted: str) -> None:
        self._note(f"{self._named(key)}: {_short(value)} is not {wanted}")

    def _note(self, text: str) -> None:
        if len(self.problems) < _MOST_PROBLEMS:
            self.problems.append(text)


def _is_number(value: object) -> bool:
    is_numeric = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_numeric and math.isfinite(value)  # type: ignore[arg-type]


def _row(value: object, width: int) -> tuple[float, ...] | None:
    if not isinstance(value, list) or not value or not is_time(value[0]):
        return None
    numbers = [float(one) if _is_number(one) else math.nan for one in value[:width]]
    return (*numbers, *(math.nan for _ in range(width - len(numbers))))


def _short(value: object) -> str:
    shown = repr(value)
    return shown if len(shown) <= 40 else f"{shown[:40]}..."
