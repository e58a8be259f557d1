"""Judges of nodes, topics, and the QoS of endpoints."""

from __future__ import annotations

import fnmatch
import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from launcher.base.document.quantities import INFINITY, NumberRange
from launcher.ros.snapshot.qos_matching import mismatches
from launcher.ros.snapshot.ros_graph import INFINITE_NS, NODE_SERVICES, Endpoint
from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import (
    Window,
    listed,
    times_text,
    with_window,
)
from launcher.smoke.observe.facts import Facts, GraphSeen

_NANOS = 1e9
_ONE_OR_MORE = NumberRange(low=1, high=INFINITY, text=">= 1")


def _shown(seen: GraphSeen, pattern: str) -> list[str]:
    """Without ghosts: a node stays in the graph for some seconds after its process is gone."""
    alive = (n for n in seen.snapshot.nodes if n not in seen.snapshot.ghosts)
    return [name for name in alive if fnmatch.fnmatchcase(name, pattern)]


def _when(facts: Facts, holds: Callable[[GraphSeen], bool], when: Window) -> float | None:
    """When a graph, which lasts until the next one, first held, also before `5` of `5 to 8 s`."""
    for seen, following in itertools.zip_longest(facts.graphs, facts.graphs[1:]):
        ends_s = INFINITY if following is None else following.at_s
        if seen.at_s <= when.to_s and ends_s > when.start_s and holds(seen):
            return max(seen.at_s, when.start_s)
    return None


def _since(facts: Facts, describe: Callable[[GraphSeen], object]) -> float | None:
    """Since when `describe` has returned the same of the graph as now."""
    seen = [graph for graph in facts.graphs if graph.at_s <= facts.stop_s]
    begin_s = None
    for graph in reversed(seen):
        if describe(graph) != describe(seen[-1]):
            break
        begin_s = graph.at_s
    return begin_s


def _held(when: Window, at_s: float, word: str = "") -> Verdict:
    if when.is_too_early(at_s):
        return when.violated(seen=f"too early, {word}after {when.since(at_s)}", at_s=at_s)
    return when.met(seen=f"{word}after {when.since(at_s)}", at_s=at_s, value=at_s, unit="s")


# ---- nodes


def _node_text(expectation: Expectation) -> str:
    verb = "is not there" if expectation.get("absent") else "is there"
    count = expectation.get("count")
    number = "" if count is None else " once" if count.text == "1" else f" {count.text} times"
    return f"node {expectation.subject} {verb}{number}{times_text(expectation)}"


@with_window(_node_text)
def node(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    pattern = expectation.subject
    if expectation.get("absent"):
        return _absent(expectation, facts, when)
    count: NumberRange = expectation.get("count", _ONE_OR_MORE)
    at_s = _when(facts, lambda seen: len(_shown(seen, pattern)) in count, when)
    if at_s is not None:
        return _held(when, at_s)
    process = facts.process_of(pattern)
    last = facts.last_graph()
    number = 0 if last is None or count is _ONE_OR_MORE else len(_shown(last, pattern))
    found = f"{number} of them" if number else "never"
    return when.not_yet(
        seen=f"{found}; known nodes: {listed(facts.graph().nodes)}",
        about=(process,) if process else (),
        guess=None if number else explain.missing_node(pattern, facts),
    )


def _absent(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """With `within`: it disappears in time; without: it never appears."""
    pattern = expectation.subject
    if expectation.within is not None:
        gone_s = _when(facts, lambda seen: not _shown(seen, pattern), when)
        if gone_s is None:
            return when.not_yet(seen="it stayed in the graph")
        return _held(when, gone_s, "gone ")
    at_s = _when(facts, lambda seen: bool(_shown(seen, pattern)), when)
    if at_s is not None:
        return when.violated(seen=f"it was there after {when.since(at_s)}", at_s=at_s)
    return when.so_far(seen="it never was")


# ---- topics


def _topic_text(expectation: Expectation) -> str:
    parts = [f"topic {expectation.subject}"]
    if expectation.get("type"):
        parts.append(f"has type {expectation.get('type')}")
    parts += [f"has {span.text} {side}" for side, span, _ in _sides(expectation, ())]
    if len(parts) == 1:
        parts.append("exists")
    return f"{parts[0]} {' and '.join(parts[1:])}{times_text(expectation)}"


@with_window(_topic_text)
def topic(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    def guess() -> str | None:
        return explain.topic(expectation.subject, expectation.get("type"), facts)

    return _without_faults(_topic_faults, expectation, facts, when, guess)


def _without_faults(
    faults: Callable[[Expectation, GraphSeen], list[str]],
    expectation: Expectation,
    facts: Facts,
    when: Window,
    guess: Callable[[], str | None],
) -> Verdict:
    """Met when a graph without faults was observed in time."""
    at_s = _when(facts, lambda seen: not faults(expectation, seen), when)
    if at_s is not None:
        return _held(when, at_s)
    last = facts.last_graph()
    now = ["no graph was observed"] if last is None else faults(expectation, last)
    return when.not_yet(
        seen="; ".join(now) or "it did hold, but not in time",
        at_s=_since(facts, lambda graph: faults(expectation, graph)),
        guess=guess(),
        about=explain.processes_on(expectation.subject, facts),
    )


def _topic_faults(expectation: Expectation, seen: GraphSeen) -> list[str]:
    topic = expectation.subject
    endpoints = seen.snapshot.on(topic)
    types = set(seen.topics.get(topic, ())) | {e.type for e in endpoints}
    faults = [] if types else [f"no topic {topic}"]
    wanted = expectation.get("type")
    if types and wanted is not None and types != {wanted}:
        faults.append(f"its type is {listed(types)}")
    for side, span, ends in _sides(expectation, endpoints):
        if len(ends) not in span:
            faults.append(f"{len(ends)} {side}: {listed(end.node for end in ends)}")
    return faults


def _sides(
    expectation: Expectation, endpoints: Iterable[Endpoint]
) -> Iterator[tuple[str, Any, list[Endpoint]]]:
    """(side, what is wanted of it, its endpoints) of the sides that an expectation names."""
    for side in ("publishers", "subscriptions"):
        wanted = expectation.get(side)
        if wanted is not None:
            yield side, wanted, [e for e in endpoints if e.is_publisher is (side == "publishers")]


# ---- services


def offered_service(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """Whether a service is in the graph, without a call."""

    def guess() -> str | None:
        return explain.missing_service(expectation.subject, facts)

    return _without_faults(_service_faults, expectation, facts, when, guess)


def _service_faults(expectation: Expectation, seen: GraphSeen) -> list[str]:
    name, wanted = expectation.subject, expectation.get("type")
    types = seen.services.get(name) or _of_every_node(name, seen)
    if not types:
        return [f"no service {name}"]
    return [] if wanted in (None, *types) else [f"its type is {listed(types)}"]


def _of_every_node(service: str, seen: GraphSeen) -> tuple[str, ...]:
    """The type of a service that nodes have without being listed, if its node is there."""
    node, _, name = service.rpartition("/")
    is_there = node in seen.snapshot.nodes and node not in seen.snapshot.ghosts
    return (NODE_SERVICES[name],) if is_there and name in NODE_SERVICES else ()


# ---- quality of service


def _qos_text(expectation: Expectation) -> str:
    parts = []
    for side, wanted, _ in _sides(expectation, ()):
        parts.append(f"{side} are {', '.join(f'{n} {_word(v)}' for n, v in wanted.items())}")
    compatible = expectation.get("compatible")
    if compatible is not None:
        parts.append("all pairs match" if compatible else "a pair does not match")
    return f"on {expectation.subject} {' and '.join(parts)}{times_text(expectation)}"


def _word(value: Any) -> str:
    return f"{value:g} s" if isinstance(value, float) else str(value).upper()


@with_window(_qos_text)
def qos(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    def guess() -> str | None:
        return explain.mismatch(expectation.subject, facts)

    return _without_faults(_qos_faults, expectation, facts, when, guess)


def _qos_faults(expectation: Expectation, seen: GraphSeen) -> list[str]:
    pattern = expectation.get("node", "*")
    endpoints = seen.snapshot.on(expectation.subject)
    chosen = [e for e in endpoints if fnmatch.fnmatchcase(e.node, pattern)]
    faults: list[str] = []
    for side, wanted, ends in _sides(expectation, chosen):
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
    nanos = {"deadline": end.deadline_ns, "lease": end.lease_ns}.get(name)
    if nanos is None:
        return getattr(end, name)
    return "infinite" if nanos >= INFINITE_NS else nanos / _NANOS


def _pair_faults(compatible: bool | None, endpoints: tuple[Endpoint, ...]) -> list[str]:
    if compatible is None:
        return []
    if len({e.is_publisher for e in endpoints}) < 2:
        return ["no pair of publisher and subscription"]
    bad = mismatches(endpoints)
    if compatible and bad:
        return [f"{m.subscription.node} receives nothing from {m.publishers[0].node}" for m in bad]
    return [] if compatible or bad else ["all pairs match"]
