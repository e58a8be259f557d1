"""Numbers in messages, by paths such as `pose.x`, `ranges[3]`, also inside strings of JSON."""

from __future__ import annotations

import math
import re
from collections import deque
from typing import Any

from launcher.base import strict_json

KEEP_POINTS = 20_000
KEEP_S = 600.0
Point = tuple[float, float | None]
_NOT_FINITE = ("nan", "inf", "-inf")  # as the probe sends them: JSON has no such numbers
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def numbers_at(data: Any, path: str) -> float | None:
    """The number (or truth value) at this path of a message; None if there is none."""
    value = data
    for name, index in _STEP.findall(path):
        value = _opened(value)
        try:
            value = value[int(index)] if index else value[name]
        except (KeyError, IndexError, TypeError):
            return None
    value = _opened(value)
    if not isinstance(value, (int, float)) and value not in _NOT_FINITE:
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _opened(value: Any) -> Any:
    """What a string of JSON holds, or the value itself."""
    if isinstance(value, str):
        try:
            return strict_json.unpacked(value)
        except ValueError:
            return value
    return value


class Series:
    """The points (wall time, value) of one plot in the last minutes.

    NaN and infinity become a gap, whose value is None.
    """

    def __init__(self) -> None:
        self._points: deque[Point] = deque(maxlen=KEEP_POINTS)
        self._new: list[Point] = []

    def add(self, wall: float, value: float | None) -> None:
        if value is None:
            return
        point = (wall, value if math.isfinite(value) else None)
        if point[1] is None and (not self._points or self._points[-1][1] is None):
            return
        self._points.append(point)
        self._new.append(point)
        while wall - self._points[0][0] > KEEP_S:
            self._points.popleft()

    def take_new(self) -> list[Point]:
        """The points since the last call."""
        new, self._new = self._new, []
        return new

    def all(self) -> list[Point]:
        return list(self._points)
