"""The rate of a topic, with a tolerance from how much it varied."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

MIN_MESSAGES = 5
PARTS = 3  # of a run: their rates differ as those of runs do
LEAST_TOLERANCE = 0.10
MOST_TOLERANCE = 0.5  # beyond it the messages have no rate
LATENCY_S = 0.005  # a busy machine makes a timer so late: much of a short period, little of a long
MOST_LATENCY = 0.2
SPREADS = 1.5  # of the greatest deviation seen, since a few runs do not show the greatest there is
STEP = 5  # percent
ROUNDING = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """`tolerance` is a share; the intervals are the shortest and the longest one."""

    hz: float
    tolerance: float
    shortest_s: float
    longest_s: float

    @property
    def text(self) -> str:
        """`1 Hz ± 15 %`, with as few digits as are within a hundredth."""
        short = (float(f"{self.hz:.{digits}g}") for digits in (1, 2))
        hz = next((one for one in short if abs(one / self.hz - 1) <= ROUNDING), self.hz)
        return f"{number_text(hz)} Hz ± {self.tolerance * 100:.0f} %"


def number_text(value: float) -> str:
    """Three digits, without an exponent."""
    digits = max(0, 2 - math.floor(math.log10(abs(value)))) if value else 0
    text = f"{value:.{digits}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def rate_of(runs: Sequence[Sequence[float]]) -> Rate | None:
    """The rate over the runs, each given as times; None if there is none to rely on."""
    if any(len(times) < MIN_MESSAGES for times in runs):
        return None
    gaps = [[later - one for one, later in itertools.pairwise(sorted(times))] for times in runs]
    if any(sum(one) <= 0 for one in gaps):
        return None
    rates = [len(one) / sum(one) for one in gaps]
    hz = sum(rates) / len(rates)
    parts = [part for one in gaps for part in _part_rates(one)]
    deviation = max(abs(rate / hz - 1) for rate in (*rates, *parts))
    latency = min(MOST_LATENCY, LATENCY_S * hz)
    tolerance = LEAST_TOLERANCE + latency + SPREADS * deviation
    percent = STEP * math.ceil(100 * tolerance / STEP - 1e-6)
    if percent > 100 * MOST_TOLERANCE:
        return None
    flat = [gap for one in gaps for gap in one]
    return Rate(hz=hz, tolerance=percent / 100, shortest_s=min(flat), longest_s=max(flat))


def _part_rates(gaps: Sequence[float]) -> list[float]:
    """The rates of all parts of a run, each so many intervals."""
    size = math.ceil(len(gaps) / PARTS)
    sums = (sum(gaps[first : first + size]) for first in range(len(gaps) - size + 1))
    return [size / total for total in sums if total > 0]
