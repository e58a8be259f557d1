"""Judges of the ROS graph: nodes, topics, and the QoS of endpoints."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from launcher.ros.snapshot.graph import INFINITE_NS, Endpoint
from launcher.ros.snapshot.qos_matching import mismatches
from launcher.smoke import guesses
from launcher.smoke.expectation import Expectation, Outcome, Period, Verdict, times_text
from launcher.smoke.facts import Facts, GraphSeen
from launcher.smoke.judges.common import (
    first_time,
    listed,
    met,
    not_yet,
    since,
    violated,
    with_period,
)
from launcher.smoke.quantities import Span

_NANOS = 1e9


def _shown(seen: GraphSeen, pattern: str) -> list[str]:
    """Nodes whose process is gone are in the graph for some seconds, but they are not there."""
    alive = (n for n in seen.snapshot.nodes if n not in seen.snapshot.ghosts)
    return [name for name in alive if fnmatch.fnmatchcase(name, pattern)]


def _when(facts: Facts, holds: Callable[[GraphSeen], bool], when: Period) -> float | None:
    """When it first held, before the window of `5 to 8 s` as well."""
    whole = replace(when, from_s=when.start_s)
    return first_time(facts.graphs, holds, whole, lambda seen: seen.at_s)


def _held(when: Period, at_s: float, expected: str, word: str = "") -> Verdict:
    """Met, or too early."""
    if when.is_too_early(at_s):
        return violated(expected, seen=f"too early, {word}after {when.since(at_s)}", at_s=at_s)
    return met(expected, seen=f"{word}after {when.since(at_s)}", at_s=at_s, value=at_s, unit="s")


# ---- nodes


def _node_text(expectation: Expectation) -> str:
    verb = "is not there" if expectation.get("absent") else "is there"
    return f"node {expectation.subject} {verb}{times_text(expectation)}"


def _node(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    pattern = expectation.subject
    if expectation.get("absent"):
        return _absent(expectation, facts, when, expected)
    at_s = _when(facts, lambda seen: bool(_shown(seen, pattern)), when)
    if at_s is not None:
        return _held(when, at_s, expected)
    process = facts.process_of(pattern)
    return not_yet(
        when,
        expected,
        seen=f"never; nodes there: {listed(facts.graph().nodes)}",
        about=(process,) if process else (),
        guess=guesses.missing_node(pattern, facts),
    )


def _absent(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    """With a time: gone at a moment of it. Without: never seen."""
    pattern = expectation.subject
    if expectation.within is not None:
        gone_s = _when(facts, lambda seen: not _shown(seen, pattern), when)
        if gone_s is None:
            return not_yet(when, expected, seen="it stayed in the graph all the time")
        return _held(when, gone_s, expected, "gone ")
    at_s = _when(facts, lambda seen: bool(_shown(seen, pattern)), when)
    if at_s is not None:
        return violated(expected, seen=f"it was there after {when.since(at_s)}", at_s=at_s)
    return _kept(when, expected, "it never was")


def _kept(when: Period, expected: str, seen: str) -> Verdict:
    """Met when the time is over."""
    outcome = Outcome.MET if when.closed else Outcome.OPEN
    return Verdict(outcome=outcome, expected=expected, seen=seen)


# ---- topics


def _topic_text(expectation: Expectation) -> str:
    parts = [f"topic {expectation.subject}"]
    if expectation.get("type"):
        parts.append(f"has type {expectation.get('type')}")
    for side in ("publishers", "subscriptions"):
        span: Span | None = expectation.get(side)
        if span is not None:
            parts.append(f"has {span.text} {side}")
    if len(parts) == 1:
        parts.append("exists")
    return f"{parts[0]} {' and '.join(parts[1:])}{times_text(expectation)}"


def _topic(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    at_s = _when(facts, lambda seen: not _topic_faults(expectation, seen), when)
    if at_s is not None:
        return _held(when, at_s, expected)
    last = facts.last_graph()
    seen = ["no graph was seen"] if last is None else _topic_faults(expectation, last)
    return not_yet(
        when,
        expected,
        seen="; ".join(seen) or "it did hold, but not in time",
        at_s=since(facts, lambda graph: _topic_faults(expectation, graph)),
        guess=guesses.topic(expectation.subject, expectation.get("type"), facts),
        about=guesses.processes_on(expectation.subject, facts),
    )


def _topic_faults(expectation: Expectation, seen: GraphSeen) -> list[str]:
    topic = expectation.subject
    endpoints = seen.snapshot.on(topic)
    types = set(seen.topics.get(topic, ())) | {e.type for e in endpoints}
    faults = [] if types else [f"there is no topic {topic}"]
    wanted = expectation.get("type")
    if types and wanted is not None and types != {wanted}:
        faults.append(f"its type is {listed(types)}")
    for side, is_publisher in (("publishers", True), ("subscriptions", False)):
        span: Span | None = expectation.get(side)
        nodes = [e.node for e in endpoints if e.is_publisher is is_publisher]
        if span is not None and len(nodes) not in span:
            faults.append(f"{len(nodes)} {side}: {listed(nodes)}")
    return faults


# ---- quality of service


def _qos_text(expectation: Expectation) -> str:
    parts = []
    for side in ("publishers", "subscriptions"):
        wanted = expectation.get(side)
        if wanted:
            parts.append(f"{side} are {', '.join(f'{n} {_word(v)}' for n, v in wanted.items())}")
    compatible = expectation.get("compatible")
    if compatible is not None:
        parts.append("all pairs match" if compatible else "a pair does not match")
    return f"on {expectation.subject} {' and '.join(parts)}{times_text(expectation)}"


def _word(value: Any) -> str:
    return f"{value:g} s" if isinstance(value, float) else str(value).upper()


def _qos(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    at_s = _when(facts, lambda seen: not _qos_faults(expectation, seen), when)
    if at_s is not None:
        return _held(when, at_s, expected)
    last = facts.last_graph()
    faults = ["no graph was seen"] if last is None else _qos_faults(expectation, last)
    return not_yet(
        when,
        expected,
        seen="; ".join(faults) or "it did hold, but not in time",
        at_s=since(facts, lambda graph: _qos_faults(expectation, graph)),
        guess=guesses.mismatch(expectation.subject, facts),
        about=guesses.processes_on(expectation.subject, facts),
    )


def _qos_faults(expectation: Expectation, seen: GraphSeen) -> list[str]:
    pattern = expectation.get("node", "*")
    endpoints = seen.snapshot.on(expectation.subject)
    chosen = [e for e in endpoints if fnmatch.fnmatchcase(e.node, pattern)]
    faults: list[str] = []
    for side, is_publisher in (("publishers", True), ("subscriptions", False)):
        wanted = expectation.get(side)
        if not wanted:
            continue
        ends = [e for e in chosen if e.is_publisher is is_publisher]
        faults += [] if ends else [f"it has no {side}" + ("" if pattern == "*" else " there")]
        faults += [fault for end in ends for fault in _differences(end, wanted)]
    return faults + _pair_faults(expectation.get("compatible"), endpoints)


def _differences(end: Endpoint, wanted: dict[str, Any]) -> list[str]:
    found = {name: _offered(end, name) for name in wanted}
    return [
        f"{end.node} has {name} {_word(found[name])}"
        for name, value in wanted.items()
        if str(found[name]).upper() != str(value).upper()
    ]


def _offered(end: Endpoint, name: str) -> Any:
    if name == "deadline":
        return "infinite" if end.deadline_ns >= INFINITE_NS else end.deadline_ns / _NANOS
    if name == "lease":
        return "infinite" if end.lease_ns >= INFINITE_NS else end.lease_ns / _NANOS
    return getattr(end, name)


def _pair_faults(compatible: bool | None, endpoints: tuple[Endpoint, ...]) -> list[str]:
    if compatible is None:
        return []
    if len({e.is_publisher for e in endpoints}) < 2:
        return ["there is no pair of publisher and subscription"]
    bad = mismatches(endpoints)
    if compatible and bad:
        return [f"{m.subscription.node} gets nothing from {m.publishers[0].node}" for m in bad]
    return [] if compatible or bad else ["all pairs match"]


node = with_period(_node, _node_text)
topic = with_period(_topic, _topic_text)
qos = with_period(_qos, _qos_text)
