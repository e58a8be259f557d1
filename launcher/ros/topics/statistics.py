"""Rates, delays and bandwidth of a topic, in the format of ros2cli. Does not import rclpy."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

NANOS = 1_000_000_000
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
        self._has_news = False
        self.count = 0

    def add(self, received_ns: int) -> None:
        if self._first_ns is None or received_ns < self._first_ns:  # or the clock was set back
            self._first_ns = received_ns
            self._intervals_ns.clear()
            self.count = 0
        else:
            self._intervals_ns.append(received_ns - self._last_ns)
        self._has_news = True
        self._last_ns = received_ns
        self.count += 1

    def due(self) -> Spread | None:
        """The window, if a message has come since it was last returned."""
        if not (self._has_news and self._intervals_ns):
            return None
        self._has_news = False
        return self.now()

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
    """The sizes of the latest `window` messages; `has_news` is for those who print them."""

    def __init__(self, window: int) -> None:
        self._sizes: deque[_Arrived] = deque(maxlen=window)
        self._first_ns: int | None = None
        self._count = self._bytes = 0
        self.has_news = False

    def __len__(self) -> int:
        return len(self._sizes)

    def add(self, received_ns: int, size_bytes: int) -> None:
        self._sizes.append(_Arrived(received_ns, size_bytes))
        self._first_ns = received_ns if self._first_ns is None else self._first_ns
        self._count += 1
        self._bytes += size_bytes
        self.has_news = True

    def due(self, now_ns: int) -> tuple[float, list[int]] | None:
        """Bytes per second up to now, and the sizes; None with fewer than two messages."""
        if len(self._sizes) < 2 or now_ns <= self._sizes[0].time_ns:
            return None
        sizes = [one.size_bytes for one in self._sizes]
        return sum(sizes) * NANOS / (now_ns - self._sizes[0].time_ns), sizes

    def total(self, end_ns: int) -> dict[str, float]:
        """Of all messages, not only of the window; a rate needs two."""
        span_ns = 0 if self._first_ns is None else end_ns - self._first_ns
        rate = self._bytes * NANOS / span_ns if self._count > 1 and span_ns > 0 else 0.0
        return {"messages": self._count, "bytes": self._bytes, "bytes_per_s": rate}


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
    """Two lines, as `ros2 topic bw` prints them."""
    bandwidth, count, mean, least, most = bandwidth_cells(rate, sizes)
    return (
        f"{bandwidth} from {count} messages\n\tMessage size mean: {mean} min: {least} max: {most}"
    )


BANDWIDTH_HEAD = ("topic", "bandwidth", "window", "mean", "min", "max")
RATE_HEAD = ("topic", "rate", "min_delta", "max_delta", "std_dev", "window")
_UNITS = ((1, 0, "B"), (1000, 2, "KB"), (1_000_000, 2, "MB"))


def bandwidth_cells(rate: float, sizes: list[int]) -> tuple[str, ...]:
    """Those of the table after the topic; one unit for all, chosen by the rate."""
    scale, digits, unit = next(u for u in _UNITS if rate < u[0] * 1000 or u is _UNITS[-1])
    bandwidth, *texts = (
        f"{value / scale:.{digits}f} {unit}"
        for value in (rate, sum(sizes) / len(sizes), min(sizes), max(sizes))
    )
    return (f"{bandwidth}/s", str(len(sizes)), *texts)


def rate_cells(found: Spread) -> tuple[str, ...]:
    """Those of the table after the topic."""
    deltas = (f"{found.min_s:.3f}", f"{found.max_s:.3f}", f"{found.std_dev_s:.5f}")
    return (f"{found.rate_hz:.3f}", *deltas, str(found.window))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as ros2cli prints it: a centred head, padded cells, and an empty line below."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    lines = [
        "   ".join(map(str.center, head, widths)),
        "=" * (sum(widths) + 3 * (len(widths) - 1)),
        *("   ".join(map(str.ljust, row, widths)) for row in rows),
    ]
    return "\n".join(lines) + "\n"
