"""Rates, delays and bandwidth of a topic, in the format of ros2cli. Does not import rclpy."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from launcher.base.text import aligned

NANOS = 1_000_000_000
REPORT_NS = NANOS
SILENT_INTERVALS = 2  # a topic that pauses for twice its longest interval has stopped


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Of a window of values, in seconds."""

    mean_s: float
    min_s: float
    max_s: float
    std_dev_s: float
    window: int

    @property
    def rate_hz(self) -> float:
        """One over the mean; 0 if that is no rate."""
        return 1.0 / self.mean_s if self.mean_s > 0 else 0.0


def spread(values_ns: Iterable[int]) -> Spread | None:
    values = list(values_ns)
    if not values:
        return None
    mean = sum(values) / len(values)
    variance = sum((value - mean) ** 2 for value in values) / len(values)
    return Spread(
        mean_s=mean / NANOS,
        min_s=min(values) / NANOS,
        max_s=max(values) / NANOS,
        std_dev_s=math.sqrt(variance) / NANOS,
        window=len(values),
    )


class Arrivals:
    """The times between the messages of one topic; the latest `window` of them."""

    def __init__(self, window: int) -> None:
        self._intervals_ns: deque[int] = deque(maxlen=window)
        self._first_ns: int | None = None
        self._last_ns = 0
        self._reported_ns: int | None = None
        self._is_reported = False
        self.count = 0

    def add(self, received_ns: int) -> None:
        if self._first_ns is None or received_ns < self._first_ns:  # or the clock was set back
            self._first_ns = received_ns
            self._intervals_ns.clear()
            self.count = 0
        else:
            self._intervals_ns.append(received_ns - self._last_ns)
        self._last_ns = received_ns
        self.count += 1

    def due(self) -> Spread | None:
        """The window, if the messages since the last report span a second."""
        if not self._intervals_ns:
            return None
        if self._reported_ns is None:
            self._reported_ns = self._last_ns
            return None
        if self._last_ns < self._reported_ns + REPORT_NS:
            return None
        self._reported_ns = self._last_ns
        self._is_reported = True
        return self.now()

    def rest(self) -> Spread | None:
        """The window at the end, if it was never due."""
        return None if self._is_reported else self.now()

    def now(self) -> Spread | None:
        return spread(self._intervals_ns)

    def mean_rate_hz(self, end_ns: int) -> float:
        """Messages per second from the first to the last; up to `end_ns` if it fell silent."""
        if self._first_ns is None or not self._intervals_ns:
            return 0.0
        fell_silent = end_ns - self._last_ns > SILENT_INTERVALS * max(self._intervals_ns)
        end_ns = end_ns if fell_silent else self._last_ns
        return (self.count - 1) * NANOS / max(1, end_ns - self._first_ns)


class Delays:
    """The ages of the latest `window` messages when they arrived."""

    def __init__(self, window: int) -> None:
        self._delays_ns: deque[int] = deque(maxlen=window)
        self._news = False

    def add(self, delay_ns: int) -> None:
        self._delays_ns.append(delay_ns)
        self._news = True

    def due(self) -> tuple[Spread, bool] | None:
        """The spread, and whether it is new since the last call; None before the first message."""
        found = spread(self._delays_ns)
        if found is None:
            return None
        fresh, self._news = self._news, False
        return found, fresh


class _Arrived(NamedTuple):
    time_ns: int
    size_bytes: int


class Bandwidth:
    def __init__(self, window: int) -> None:
        self._sizes: deque[_Arrived] = deque(maxlen=window)

    def __len__(self) -> int:
        return len(self._sizes)

    def add(self, received_ns: int, size_bytes: int) -> None:
        self._sizes.append(_Arrived(received_ns, size_bytes))

    def due(self, now_ns: int) -> tuple[float, list[int]] | None:
        """Bytes per second up to now, and the sizes; None with fewer than two messages."""
        if len(self._sizes) < 2 or now_ns <= self._sizes[0].time_ns:
            return None
        sizes = [one.size_bytes for one in self._sizes]
        return sum(sizes) * NANOS / (now_ns - self._sizes[0].time_ns), sizes


def rate_text(found: Spread) -> str:
    """Two lines, as `ros2 topic hz` prints them."""
    return f"average rate: {found.rate_hz:.3f}\n{_spread_text(found)}"


def delay_text(found: Spread, *, fresh: bool) -> str:
    """Two lines, as `ros2 topic delay` prints them, or one without a new message."""
    if not fresh:
        return "no new messages"
    return f"average delay: {found.mean_s:.3f}\n{_spread_text(found)}"


def _spread_text(found: Spread) -> str:
    return (
        f"\tmin: {found.min_s:.3f}s max: {found.max_s:.3f}s "
        f"std dev: {found.std_dev_s:.5f}s window: {found.window}"
    )


def bandwidth_text(rate: float, sizes: list[int]) -> str:
    """Two lines, as `ros2 topic bw` prints them; one unit for all, chosen by the rate."""
    scale, digits, unit = next(u for u in _UNITS if rate < u[0] * 1000 or u is _UNITS[-1])
    texts = [
        f"{value / scale:.{digits}f} {unit}"
        for value in (rate, sum(sizes) / len(sizes), min(sizes), max(sizes))
    ]
    return (
        f"{texts[0]}/s from {len(sizes)} messages\n"
        f"\tMessage size mean: {texts[1]} min: {texts[2]} max: {texts[3]}"
    )


_UNITS = ((1, 0, "B"), (1000, 2, "KB"), (1_000_000, 2, "MB"))


def rate_table(rows: dict[str, Spread]) -> str:
    head = ("topic", "rate", "min_delta", "max_delta", "std_dev", "window")
    cells = [head] + [
        (
            topic,
            f"{s.rate_hz:.3f}",
            f"{s.min_s:.3f}",
            f"{s.max_s:.3f}",
            f"{s.std_dev_s:.5f}",
            str(s.window),
        )
        for topic, s in rows.items()
    ]
    lines = aligned(cells)
    return "\n".join([lines[0], "=" * max(map(len, lines)), *lines[1:]])
