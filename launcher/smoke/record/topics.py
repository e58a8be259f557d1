"""Expectations about topics: endpoints, quality of service and rates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from launcher.ros.snapshot.graph import INFINITE_NS, Endpoint
from launcher.ros.snapshot.qos_matching import mismatches
from launcher.smoke.expect.expectation import READY
from launcher.smoke.expect.expectation_kinds import DURABILITIES, RELIABILITIES
from launcher.smoke.record.names import is_pattern
from launcher.smoke.record.rates import number_text, rate_of
from launcher.smoke.record.runs import RecordedExpectation, Runs, after_text, note, within
from launcher.smoke.record.watch import is_heavy

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
