"""Expectations about when messages come: the gaps between them, and their latency."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

from launcher.smoke.expect.expectation import READY
from launcher.smoke.judges.time_series import latency_s
from launcher.smoke.judges.timeliness import duration_text
from launcher.smoke.record.observed_run import ObservedRun
from launcher.smoke.record.recorded_runs import RecordedExpectation, Runs, note
from launcher.smoke.record.topic_expectations import MIN_MESSAGES, names_of, rate_of

TIMES_LONGER = 3.0
LEAST_GAP_S = 1.0  # a busy machine makes a pause of this length on any topic
LEAST_LATENCY_S = 0.2
MOST_LATENCY_S = 10.0  # more is no latency: stamps of a bag or of simulated time
_STEPS = (1.0, 2.0, 5.0, 10.0)


def timeliness(runs: Runs) -> Iterator[RecordedExpectation]:
    """Of topics with a rate. Limits are rounded up, so that most recordings have the same."""
    for name in names_of(runs):
        times = [run.message_times(name) for run in runs]
        if rate_of(times) is None:
            continue
        longest_s = max(b - a for one in times for a, b in itertools.pairwise(one))
        limit = duration_text(limit_s(longest_s, LEAST_GAP_S))
        seen = f"seen {duration_text(round(longest_s, 2))} at most"
        yield RecordedExpectation({"gap": name, "below": limit, "after": READY}, seen)
        yield from _latency(name, runs)


def _latency(name: str, runs: Runs) -> Iterator[RecordedExpectation]:
    """Of messages that begin with a stamp: others are as old as the probe is late."""
    delays = [_delays(name, run) for run in runs]
    if any(len(one) < MIN_MESSAGES for one in delays):
        return
    values_s = [latency_s(one) for one in delays]
    if not 0 <= min(values_s) <= max(values_s) <= MOST_LATENCY_S:
        yield note(f"{name}: its stamps are no times of day, or of another clock")
        return
    limit = duration_text(limit_s(max(values_s), LEAST_LATENCY_S))
    seen = f"seen {_range_text(values_s)}"
    yield RecordedExpectation({"latency": name, "below": limit, "after": READY}, seen)


def _delays(name: str, run: ObservedRun) -> list[float]:
    return [
        message.at_s - message.stamp_s
        for message in run.facts.received(name)
        if message.stamp_s is not None and run.begin_s <= message.at_s <= run.facts.stop_s
    ]


def _range_text(values_s: Sequence[float]) -> str:
    return " and ".join(dict.fromkeys(duration_text(round(value_s, 3)) for value_s in values_s))


def limit_s(seen_s: float, least_s: float) -> float:
    """Several times what was seen, rounded up to 1, 2 or 5 times a power of ten."""
    value_s = max(least_s, TIMES_LONGER * seen_s)
    power = 10.0 ** math.floor(math.log10(value_s))
    return next(step * power for step in _STEPS if step * power >= value_s * (1 - 1e-9))
