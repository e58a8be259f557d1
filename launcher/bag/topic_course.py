"""How often messages of a topic come: rates, gaps, and the course of the rate over time."""

from __future__ import annotations

import bisect
import itertools
import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

NS = 10**9
_GAP_PERIODS = 3  # a longer interval than so many usual ones is a gap
_SAMPLE = 10_000  # intervals that are looked at for the usual one


class MessageGap(NamedTuple):
    """The longest time without a message, and when it began."""

    length_ns: int
    start_ns: int


def mean_hz(times_ns: Sequence[int]) -> float | None:
    """The rate between the first and the last message; None if it cannot be determined."""
    if len(times_ns) < 2 or times_ns[-1] == times_ns[0]:
        return None
    return (len(times_ns) - 1) * NS / (times_ns[-1] - times_ns[0])


def longest_gap(times_ns: Sequence[int]) -> MessageGap | None:
    """The longest interval between two messages; None with fewer than two."""
    gaps = (MessageGap(b - a, a) for a, b in itertools.pairwise(times_ns))
    return max(gaps, key=lambda gap: gap.length_ns, default=None)


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


def course(times_ns: Sequence[int], start_ns: int, end_ns: int, parts: int) -> Course:
    """Of sorted times, all of them between `start_ns` and `end_ns`."""
    if not times_ns or end_ns <= start_ns or parts < 1:
        return Course((None,) * max(parts, 0))
    width_ns = (end_ns - start_ns) / parts
    numbers, covered = [0.0] * parts, [0.0] * parts
    alone: set[int] = set()

    def part_of(time_ns: float) -> int:
        return max(0, min(parts - 1, int((time_ns - start_ns) / width_ns)))

    def add(part: int, number: float, time_ns: float, *, is_single: bool = False) -> None:
        if is_single and not covered[part]:
            alone.add(part)
        else:
            alone.discard(part)
        numbers[part] += number
        covered[part] += time_ns

    for first, last in _streaks(times_ns):
        streak = times_ns[first], times_ns[last]
        if streak[0] == streak[1]:
            add(part_of(streak[0]), last - first + 1, width_ns, is_single=first == last)
            continue
        for part in range(part_of(streak[0]), part_of(streak[1]) + 1):
            begin = max(streak[0], start_ns + part * width_ns)
            end = min(streak[1], start_ns + (part + 1) * width_ns)
            if end > begin:
                number = _index(times_ns, end, first, last) - _index(times_ns, begin, first, last)
                add(part, number, end - begin)
    return Course(
        tuple(
            number * NS / min(max(time_ns, 1.0), width_ns) if time_ns else None
            for number, time_ns in zip(numbers, covered, strict=True)
        ),
        frozenset(alone),
    )


def _streaks(times_ns: Sequence[int]) -> Iterator[tuple[int, int]]:
    """The first and the last index of messages without a gap between them."""
    sample = times_ns[: _SAMPLE + 1]
    usual_ns = statistics.median(b - a for a, b in itertools.pairwise(sample)) if sample[1:] else 0
    limit_ns = max(_GAP_PERIODS * usual_ns, 1)
    first = 0
    for index, (a, b) in enumerate(itertools.pairwise(times_ns)):
        if b - a > limit_ns:
            yield first, index
            first = index + 1
    yield first, len(times_ns) - 1


def _index(times_ns: Sequence[int], at_ns: float, low: int, high: int) -> float:
    """The number of messages before a time, with the part of the interval that it is in."""
    after = min(max(bisect.bisect_right(times_ns, at_ns, low, high + 1), low + 1), high)
    before_ns, after_ns = times_ns[after - 1], times_ns[after]
    if after_ns == before_ns:
        return float(after)
    return after - 1 + min(1.0, max(0.0, (at_ns - before_ns) / (after_ns - before_ns)))


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
