"""What judges measure of plain times and values: rates, pauses, delays, growth.

The times may be on any clock, in seconds; those of messages are sorted. Nothing here depends on how
they were observed, so that a run that goes on is measured in the same way.
"""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

MIN_MESSAGES = 3  # fewer have no rate, and no latency
SILENT_INTERVALS = 2  # of the longest one: a topic that pauses longer has stopped
LATENCY_SHARE = 0.95  # of the messages, whose latency is judged
GROWTH_S = 10.0  # over less, memory that is allocated in steps has no slope
START_UP_S = 5.0  # of a process, in which it imports modules and discovers others
_MOST_SAMPLES = 200  # have 20,000 slopes, 10 ms


@dataclass(frozen=True, slots=True, kw_only=True)
class Pause:
    """From `start_s` to `end_s`; `is_open`: no message has ended it."""

    start_s: float
    end_s: float
    is_open: bool = False

    @property
    def length_s(self) -> float:
        return self.end_s - self.start_s


# ---- times of messages


def rate(
    times: Sequence[float], from_s: float, to_s: float, *, counts_start: bool
) -> tuple[float, float]:
    """(messages per second, seconds it was measured over) of at least two messages.

    From the intervals between messages. A topic that fell silent is measured up to `to_s`; with
    `counts_start`, one that began late is measured from `from_s`.
    """
    first_s = times[0]
    last_s = to_s if fell_silent(times, to_s) else times[-1]
    if counts_start and first_s - from_s > longest_pause_s(times):
        first_s = from_s
    seconds = max(last_s - first_s, 1e-9)
    return (len(times) - 1) / seconds, seconds


def fell_silent(times: Sequence[float], to_s: float) -> bool:
    """Whether at least two messages are followed by a pause that is no interval of theirs."""
    return to_s - times[-1] > longest_pause_s(times)


def longest_pause_s(times: Sequence[float]) -> float:
    """How long a topic with these messages may pause without having stopped."""
    return SILENT_INTERVALS * max(b - a for a, b in itertools.pairwise(times))


def longest_gap(
    times: Sequence[float], from_s: float, to_s: float, *, counts_start: bool
) -> Pause | None:
    """The longest pause between messages, or after the last one until `to_s`.

    With `counts_start` also that before the first. None if nothing bounds a pause.
    """
    starts = [from_s, *times] if counts_start else [*times]
    if not starts:
        return None
    ends = [*starts[1:], max(to_s, starts[-1])]
    start_s, end_s = max(zip(starts, ends, strict=True), key=lambda pair: pair[1] - pair[0])
    return Pause(start_s=start_s, end_s=end_s, is_open=start_s == starts[-1])


def latency_s(delays_s: Iterable[float]) -> float:
    """The delay that LATENCY_SHARE of the messages do not exceed; of at least one message."""
    ordered = sorted(delays_s)
    return ordered[math.ceil(LATENCY_SHARE * len(ordered)) - 1]


# ---- values


def growth_per_s(samples: Sequence[tuple[float, float]]) -> float | None:
    """The slope of (time, value) samples, sorted by time; None if they span less than GROWTH_S.

    It is the median of the slopes between all pairs of samples (Theil 1950, Sen 1968), which a
    single step or peak does not move. Of many samples, evenly chosen ones are used.
    """
    if not samples or samples[-1][0] - samples[0][0] < GROWTH_S:
        return None
    chosen = samples[:: math.ceil(len(samples) / _MOST_SAMPLES)]
    slopes = [
        (b - a) / (later_s - at_s)
        for (at_s, a), (later_s, b) in itertools.combinations(chosen, 2)
        if later_s > at_s
    ]
    return statistics.median(slopes) if slopes else None
