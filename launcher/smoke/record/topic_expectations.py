"""Expectations about topics: endpoints, quality of service and rates."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.ros.snapshot.qos_matching import mismatches
from launcher.ros.snapshot.ros_graph import INFINITE_NS, Endpoint
from launcher.smoke.expect.expectation import READY
from launcher.smoke.expect.expectation_kinds import DURABILITIES, RELIABILITIES
from launcher.smoke.record.name_patterns import is_pattern
from launcher.smoke.record.recorded_runs import RecordedExpectation, Runs, after_text, note, within
from launcher.smoke.record.watched_run import is_heavy

SIDES = ("publishers", "subscriptions")
_NANOS = 1e9
MANY_MESSAGES = 8  # of a topic without a rate: another run will hardly have none


def names_of(runs: Runs) -> list[str]:
    """The topics of every run; those with another name in each run cannot be named."""
    return [name for name in runs.topics.common() if not is_pattern(name)]


def topics(runs: Runs) -> Iterator[RecordedExpectation]:
    for name in names_of(runs):
        yield _topic(name, runs)
    for name in runs.topics.common():
        if is_pattern(name):
            yield note(f"{name}: another name in each run")
    for name in runs.topics.missing():
        yield note(f"{name}: not in every run")


def _topic(name: str, runs: Runs) -> RecordedExpectation:
    values: dict[str, Any] = {"topic": name}
    types = {end.type for run in runs for end in run.topics[name]}
    if len(types) == 1:
        values["type"] = types.pop()
    varied = []
    for side in SIDES:
        numbers = [run.counts(name, publishers=side == SIDES[0]) for run in runs]
        least, most = min(low for low, _ in numbers), max(high for _, high in numbers)
        if least == most:
            values[side] = least
            continue
        varied.append(f"{least} to {most} {side}")
        if least:
            values[side] = f">= {least}"
    times_s = [run.topic_since(name) for run in runs]
    values["within"] = within(times_s)
    return RecordedExpectation(values, ", ".join([after_text(times_s), *varied]))


# ---- quality of service


def qualities(runs: Runs) -> Iterator[RecordedExpectation]:
    for name in names_of(runs):
        ends = [end for run in runs for end in run.topics[name]]
        common: dict[str, Any] = {}
        for side in SIDES:
            policies = _policies([e for e in ends if e.is_publisher is (side == SIDES[0])])
            if len(policies) == 1:
                common[side] = policies[0]
            elif policies:
                yield from _by_node(name, side, runs)
        yield from _of_all(name, common, runs)


def _of_all(name: str, common: dict[str, Any], runs: Runs) -> Iterator[RecordedExpectation]:
    ends = [run.topics[name] for run in runs]
    seen = ""
    if all(len({e.is_publisher for e in one}) == 2 for one in ends):
        unmatched = [mismatches(one) for one in ends]
        if all(unmatched) or not any(unmatched):
            common = {**common, "compatible": not any(unmatched)}
        if all(unmatched):
            names = dict.fromkeys(one.subscription.node for one in unmatched[0])
            seen = f"{', '.join(names)} requests more than is offered"
    if common:
        yield RecordedExpectation({"qos": name, **common, "within": _qos_within(name, runs)}, seen)


def _by_node(name: str, side: str, runs: Runs) -> Iterator[RecordedExpectation]:
    """Where the endpoints of a topic differ."""
    found: dict[str | None, list[Endpoint]] = {}
    for number, run in enumerate(runs):
        for end in run.topics[name]:
            if end.is_publisher is (side == SIDES[0]):
                found.setdefault(runs.nodes.of(end.node, number), []).append(end)
    for node, ends in sorted(found.items(), key=lambda item: item[0] or ""):
        policies = _policies(ends)
        if node is None or len(policies) != 1:
            nodes = ", ".join(sorted({end.node for end in ends}))
            yield note(f"{side} of {name} in {nodes}: not the same in every run, or several")
            continue
        values = {"qos": name, "node": node, side: policies[0], "within": _qos_within(name, runs)}
        yield RecordedExpectation(values, "")


def _qos_within(name: str, runs: Runs) -> str:
    return within([run.topic_since(name) for run in runs])


def _policies(ends: Sequence[Endpoint]) -> list[dict[str, str]]:
    """Every different quality of service, as it is written; what is the default is left out."""
    found: list[dict[str, str]] = []
    for end in ends:
        policies = {"reliability": end.reliability.lower(), "durability": end.durability.lower()}
        known = {"reliability": RELIABILITIES, "durability": DURABILITIES}
        policies = {name: word for name, word in policies.items() if word in known[name]}
        if end.liveliness == "MANUAL_BY_TOPIC":
            policies["liveliness"] = "manual_by_topic"
        times = {"deadline": end.deadline_ns, "lease": end.lease_ns}
        policies |= {name: _seconds(ns) for name, ns in times.items() if ns < INFINITE_NS}
        if policies and policies not in found:
            found.append(policies)
    return found


def _seconds(nanoseconds: int) -> str:
    return f"{nanoseconds / _NANOS:.9f}".rstrip("0").rstrip(".") + " s"


# ---- messages


def rates(runs: Runs) -> Iterator[RecordedExpectation]:
    for name in names_of(runs):
        ends = [end for run in runs for end in run.topics[name]]
        if not any(end.is_publisher for end in ends):
            continue
        if is_heavy([end.type for end in ends]):
            yield note(f"{name}: messages of this type are too large to be counted")
            continue
        times = [run.message_times(name) for run in runs]
        rate = rate_of(times)
        if rate is not None:
            gaps = f"intervals of {number_text(rate.shortest_s)} to {number_text(rate.longest_s)} s"
            values = {"rate": name, "is": rate.text, "after": READY}
            yield RecordedExpectation(values, f"seen {_rates_text(times)} Hz, {gaps}")
            continue
        yield from _some_messages(name, ends, runs)


def _some_messages(
    name: str, ends: Sequence[Endpoint], runs: Runs
) -> Iterator[RecordedExpectation]:
    """Of a topic without a rate: that there are messages, if that is certain."""
    numbers = [len(run.facts.received(name)) for run in runs]
    seen = f"{' and '.join(map(str, numbers))} messages"
    is_kept = all(end.durability == "TRANSIENT_LOCAL" for end in ends if end.is_publisher)
    if is_kept and all(numbers):
        yield RecordedExpectation({"message": name}, f"seen {seen}, kept for late subscriptions")
    elif min(numbers) >= MANY_MESSAGES:
        yield RecordedExpectation({"message": name}, f"seen {seen}, at no steady rate")
    elif any(numbers):
        yield note(f"{name}: {seen}, at no steady rate")


def _rates_text(runs: Sequence[Sequence[float]]) -> str:
    rates = [(len(times) - 1) / (times[-1] - times[0]) for times in runs]
    return " and ".join(dict.fromkeys(number_text(rate) for rate in rates))


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
