"""Numbers in messages, by paths such as `pose.x`, `ranges[3]`, also inside strings of JSON."""

from __future__ import annotations

import json
import math
import re
from collections import deque
from typing import Any

KEEP_POINTS = 20_000
KEEP_S = 600.0
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def numbers_at(data: Any, path: str) -> float | None:
    """The finite number (or truth value) at this path of a message; None if there is none."""
    value = data
    for name, index in _STEP.findall(path):
        value = _opened(value)
        try:
            value = value[int(index)] if index else value[name]
        except (KeyError, IndexError, TypeError):
            return None
    value = _opened(value)
    if isinstance(value, (int, float)):
        return _finite(value)
    return None


def _finite(value: float) -> float | None:
    """JSON has no nan and no infinity."""
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _opened(value: Any) -> Any:
    """What a string of JSON holds, or the value itself."""
    if isinstance(value, str):
        try:
            return json.loads(value)
        except ValueError:
            return value
    return value


class Series:
    """The points (wall time, value) of one plot in the last minutes."""

    def __init__(self) -> None:
        self._points: deque[tuple[float, float]] = deque(maxlen=KEEP_POINTS)
        self._new: list[tuple[float, float]] = []

    def add(self, wall: float, value: float | None) -> None:
        if value is None:
            return
        self._points.append((wall, value))
        self._new.append((wall, value))
        while wall - self._points[0][0] > KEEP_S:
            self._points.popleft()

    def take_new(self) -> list[tuple[float, float]]:
        """The points since the last call."""
        new, self._new = self._new, []
        return new

    def all(self) -> list[tuple[float, float]]:
        return list(self._points)
