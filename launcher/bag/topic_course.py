"""How often messages of a topic come: rates, gaps, and the course of the rate over time."""

from __future__ import annotations

import bisect
import itertools
import operator
import statistics
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

NS = 10**9
_GAP_PERIODS = 3  # a longer interval than so many usual ones is a gap
_SAMPLE = 10_000  # intervals that are looked at for the usual one


class MessageGap(NamedTuple):
    """The longest time without a message, and when it began."""

    length_ns: int
    start_ns: int


@dataclass(frozen=True, slots=True)
class Course:
    """The rate in each part of a time; None: no message came then.

    Of a topic that is slow compared to the parts, each interval between two messages counts in all
    parts that it covers, so that a steady topic is steady.

    A part in `alone` has a single message, with none near it: it is in a bar, but a rate needs two
    messages, so it is neither the least nor the highest.
    """

    parts_hz: tuple[float | None, ...]
    alone: frozenset[int] = frozenset()

    @property
    def least_hz(self) -> float | None:
        return min(self._known(), default=None)

    @property
    def most_hz(self) -> float | None:
        return max(self._known(), default=None)

    def _known(self) -> Iterator[float]:
        return (
            rate
            for part, rate in enumerate(self.parts_hz)
            if rate is not None and part not in self.alone
        )


class TopicTimes:
    """What the times of a topic show, which are added in blocks and not kept.

    All are sorted, and equal ones in the same block. With `parts`, all of them are between
    `start_ns` and `end_ns`.
    """

    def __init__(self, start_ns: int = 0, end_ns: int = 0, parts: int = 0) -> None:
        self.count = 0
        self.first_ns = 0
        self.longest_gap: MessageGap | None = None  # None with fewer than two messages
        self._last_ns = 0
        self._parts = parts
        self._course = _Parts(start_ns, end_ns, parts) if parts > 0 and end_ns > start_ns else None

    @property
    def mean_hz(self) -> float | None:
        """The rate between the first and the last message; None if it cannot be determined."""
        if self._last_ns == self.first_ns:
            return None
        return (self.count - 1) * NS / (self._last_ns - self.first_ns)

    def add(self, times_ns: Sequence[int]) -> None:
        if not times_ns:
            return
        if not self.count:
            self.first_ns = self._last_ns = times_ns[0]
        self.count += len(times_ns)
        intervals = _intervals(self._last_ns, times_ns)
        longest = max(intervals)
        gap = self.longest_gap
        if self.count > 1 and (gap is None or longest > gap.length_ns):
            end_ns = times_ns[intervals.index(longest)]
            self.longest_gap = MessageGap(longest, end_ns - longest)
        if self._course is not None:
            self._course.add(times_ns)
        self._last_ns = times_ns[-1]

    def course(self) -> Course:
        """After the last block."""
        if self._course is None or not self.count:
            return Course((None,) * self._parts)
        return self._course.finish()


def _intervals(before_ns: int, times_ns: Sequence[int]) -> array[int]:
    """To each of these times, from the one before it."""
    return array("q", map(operator.sub, times_ns, itertools.chain((before_ns,), times_ns)))


class _Parts:
    """The numbers of messages in the parts of a time, and how much of each part these cover.

    The messages without a gap between them are a streak. Of the open one, its first and last time
    are known; it is in no part while these are the same.
    """

    def __init__(self, start_ns: int, end_ns: int, parts: int) -> None:
        self._start_ns = start_ns
        self._width_ns = (end_ns - start_ns) / parts
        self._numbers, self._covered = [0.0] * parts, [0.0] * parts
        self._alone: set[int] = set()
        self._sample = array("q")
        self._limit_ns = 0.0  # longer intervals are gaps; 0 until it is known
        self._first_ns = self._last_ns = self._number = 0

    def add(self, times_ns: Sequence[int]) -> None:
        if self._limit_ns:
            self._take(times_ns)
            return
        self._sample.extend(times_ns)
        if len(self._sample) > _SAMPLE:
            self._take_sample()

    def _take_sample(self) -> None:
        intervals = _intervals(self._sample[0], self._sample[: _SAMPLE + 1])[1:]
        usual_ns = statistics.median(intervals) if intervals else 0
        self._limit_ns = max(_GAP_PERIODS * usual_ns, 1)
        self._first_ns = self._last_ns = self._sample[0]
        self._take(self._sample)
        self._sample = array("q")

    def _take(self, times_ns: Sequence[int]) -> None:
        first = 0
        intervals = _intervals(self._last_ns, times_ns)
        if max(intervals) > self._limit_ns:
            for index, interval_ns in enumerate(intervals):
                if interval_ns > self._limit_ns:
                    self._extend(times_ns[first:index])
                    self._end()
                    first, self._first_ns = index, times_ns[index]
                    self._last_ns = self._first_ns
        self._extend(times_ns[first:])

    def _extend(self, times_ns: Sequence[int]) -> None:
        """Continue the streak. Equal times at its begin are no rate yet."""
        if not times_ns:
            return
        points = array("q", times_ns)
        if self._number:
            points.insert(0, self._last_ns)
        self._number += len(times_ns)
        self._last_ns = points[-1]
        for part in range(self._part_of(points[0]), self._part_of(points[-1]) + 1):
            begin, end = max(points[0], self._edge(part)), min(points[-1], self._edge(part + 1))
            if end > begin:
                self._add(part, _index(points, end) - _index(points, begin), end - begin)

    def _end(self) -> None:
        """The streak is over."""
        if self._number and self._first_ns == self._last_ns:
            part = self._part_of(self._first_ns)
            is_alone = self._number == 1 and not self._covered[part]
            self._add(part, self._number, self._width_ns)
            if is_alone:
                self._alone.add(part)
        self._number = 0

    def _part_of(self, time_ns: int) -> int:
        part = int((time_ns - self._start_ns) / self._width_ns)
        return max(0, min(len(self._numbers) - 1, part))

    def _edge(self, part: int) -> int:
        """Where a part begins: an integer, as floats are not exact for times of today."""
        return self._start_ns + int(part * self._width_ns)

    def _add(self, part: int, number: float, covered_ns: float) -> None:
        self._alone.discard(part)
        self._numbers[part] += number
        self._covered[part] += covered_ns

    def finish(self) -> Course:
        if self._sample:
            self._take_sample()
        self._end()
        return Course(
            tuple(
                number * NS / min(max(covered_ns, 1.0), self._width_ns) if covered_ns else None
                for number, covered_ns in zip(self._numbers, self._covered, strict=True)
            ),
            frozenset(self._alone),
        )


def _index(times_ns: Sequence[int], at_ns: int) -> float:
    """The number of messages before a time, with the part of the interval that it is in."""
    last = len(times_ns) - 1
    after = min(max(bisect.bisect_right(times_ns, at_ns), 1), last)
    before_ns, after_ns = times_ns[after - 1], times_ns[after]
    if after_ns == before_ns:
        return float(after)
    return after - 1 + min(1.0, max(0.0, (at_ns - before_ns) / (after_ns - before_ns)))


def measured(
    blocks: Iterable[tuple[str, Sequence[int]]], begin: Callable[[], TopicTimes] = TopicTimes
) -> dict[str, TopicTimes]:
    """What the blocks of each topic show; `begin` makes what they are added to."""
    found: dict[str, TopicTimes] = {}
    for topic, times_ns in blocks:
        if topic not in found:
            found[topic] = begin()
        found[topic].add(times_ns)
    return found


# The characters of bars, for the least rate to the highest one.
BLOCKS = "▁▂▃▄▅▆▇█"
ASCII_BLOCKS = ".:-=+*#@"


def bar(parts_hz: Sequence[float | None], blocks: str = BLOCKS) -> str:
    """A character for each part; a space where no message came. The fullest is the highest rate."""
    most = max((one for one in parts_hz if one is not None), default=0.0)
    return "".join(
        " " if one is None else blocks[_level(one, most, len(blocks))] for one in parts_hz
    )


def _level(rate_hz: float, most_hz: float, levels: int) -> int:
    return min(levels - 1, max(0, round(rate_hz / most_hz * levels) - 1)) if most_hz else 0
