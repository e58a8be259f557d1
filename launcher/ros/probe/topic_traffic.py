"""How much arrives on a topic now: rate and bytes over the last seconds. Does not import rclpy."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

NANOS = 1_000_000_000
WINDOW_NS = 5 * NANOS
_BUCKET_NS = NANOS // 4
_SHORTEST_NS = NANOS  # a burst that has just come is not a rate
_SILENT_INTERVALS = 2


@dataclass(slots=True)
class _Bucket:
    """Messages that came within a quarter of a second."""

    number: int
    first_ns: int
    last_ns: int
    count: int = 0
    size_bytes: int = 0


class Traffic:
    """The messages of the last 5 s, in buckets: asking takes as long for many as for few."""

    def __init__(self) -> None:
        self._buckets: deque[_Bucket] = deque()

    def add(self, at_ns: int, size_bytes: int) -> None:
        number = at_ns // _BUCKET_NS
        if not self._buckets or number > self._buckets[-1].number:
            self._buckets.append(_Bucket(number, at_ns, at_ns))
            self._forget(at_ns)
        bucket = self._buckets[-1]
        bucket.last_ns = max(bucket.last_ns, at_ns)
        bucket.count += 1
        bucket.size_bytes += size_bytes

    def _forget(self, now_ns: int) -> None:
        oldest = (now_ns - WINDOW_NS) // _BUCKET_NS
        while self._buckets and self._buckets[0].number <= oldest:
            self._buckets.popleft()

    def rate_hz(self, now_ns: int, since_ns: int) -> float:
        """From the first message of the window to the last, or to now after a silence.

        A single message counts for the whole window, which begins at `since_ns` at the earliest.
        """
        self._forget(now_ns)
        if not self._buckets:
            return 0.0
        count = sum(bucket.count for bucket in self._buckets)
        first_ns, last_ns = self._buckets[0].first_ns, self._buckets[-1].last_ns
        span_ns = last_ns - first_ns
        if count == 1:
            return NANOS / max(_SHORTEST_NS, min(WINDOW_NS, now_ns - since_ns))
        if span_ns and now_ns - last_ns <= _SILENT_INTERVALS * span_ns / (count - 1):
            return (count - 1) * NANOS / span_ns
        return count * NANOS / max(_SHORTEST_NS, now_ns - first_ns)

    def mean_bytes(self) -> float:
        """Of a message."""
        count = sum(bucket.count for bucket in self._buckets)
        return sum(bucket.size_bytes for bucket in self._buckets) / max(1, count)
