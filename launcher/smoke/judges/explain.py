"""Probable causes of unmet expectations, derived from the facts; None where they show none."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from launcher.base.model.run_event import exit_text
from launcher.base.model.run_events import NotStarted
from launcher.base.text import did_you_mean
from launcher.ros.snapshot.qos_matching import faults, mismatches
from launcher.ros.snapshot.ros_graph import INFINITE_NS, NODE_SERVICES, Endpoint
from launcher.smoke.expect.expectation import LAUNCHER
from launcher.smoke.judges.common import shorten
from launcher.smoke.observe.facts import Facts

BUSY_PERCENT = 90.0  # of one core, which is all that a Python node can use


def processes_on(topic: str, facts: Facts) -> tuple[str, ...]:
    """The processes of the publishers of a topic, two at most."""
    nodes = [e.node for e in facts.endpoints(topic) if e.is_publisher]
    found = (facts.process_of(node) for node in nodes)
    return tuple(dict.fromkeys(name for name in found if name))[:2]


def last_exception(process: str, facts: Facts) -> str | None:
    for one in reversed(facts.last_lines(process, 20)):
        head, colon, _ = one.plain.partition(":")
        if colon and head.rpartition(".")[2].endswith(("Error", "Exception")):
            return f"it raised {one.plain}"
    return None


def _ended(process: str, facts: Facts) -> str | None:
    """`ended at 3.0 s (exit code 1); it raised ...` of a process that does not run any more."""
    end = facts.last_end(process)
    if end is None or facts.was_running(process, facts.stop_s):
        return None
    why = last_exception(process, facts)
    text = f"ended at {end.at_s:.1f} s ({exit_text(end.event.returncode)})"
    return text + (f"; {why}" if why else "")


def _elsewhere(noun: str, name: str, known: Iterable[str]) -> str | None:
    """Where the same name exists in another namespace."""
    base = name.rpartition("/")[2]
    found = [one for one in known if one.rpartition("/")[2] == base]
    return f"there is a {noun} of that name elsewhere: {', '.join(found)}" if found else None


def missing_node(node: str, facts: Facts) -> str | None:
    process = facts.process_of(node)
    known = facts.graph().nodes
    if process is None:
        if not facts.processes():
            return "no process was started"
        similar = did_you_mean(node, known)
        if similar:
            return f"no process of the launch file has this node; {similar}"
        return _elsewhere("node", node, known)
    for start in facts.of(NotStarted, process):
        return f"its process {process} {start.event.text}"
    ended = _ended(process, facts)
    if ended:
        return f"its process {process} {ended}"
    elsewhere = _elsewhere("node", node, known)
    return elsewhere or f"its process {process} was running without a node {node}"


def topic(name: str, wanted_type: str | None, facts: Facts) -> str | None:
    endpoints = facts.endpoints(name)
    types = {e.type: e.node for e in endpoints}
    if wanted_type and types and wanted_type not in types:
        found = ", ".join(f"{node} uses {kind}" for kind, node in types.items())
        return f"the topic has another type: {found}"
    return _gone_publisher(name, facts) if endpoints else _missing_topic(name, facts)


def _missing_topic(name: str, facts: Facts) -> str | None:
    known = [t for t in facts.graph().topics() if t not in ("/rosout", "/parameter_events")]
    elsewhere = _elsewhere("topic", name, known)
    similar = did_you_mean(name, known)
    return elsewhere or (f"no node has this topic; {similar}" if similar else None)


def _gone_publisher(name: str, facts: Facts) -> str | None:
    """A node that has stopped publishing."""
    before = {e.node for seen in facts.graphs for e in seen.snapshot.on(name) if e.is_publisher}
    now = {e.node for e in facts.endpoints(name) if e.is_publisher} - set(facts.graph().ghosts)
    for node in sorted(before - now):
        process = facts.process_of(node)
        end = facts.last_end(process) if process else None
        ended = f": its process {process} ended at {end.at_s:.1f} s" if end else ""
        return f"{node} published it and does not any more{ended}"
    return None


def mismatch(name: str, facts: Facts) -> str | None:
    for found in mismatches(facts.endpoints(name)):
        fault = found.faults[0]
        return (
            f"{found.subscription.shown_node} receives nothing from "
            f"{found.publishers[0].shown_node}: "
            f"{fault.policy.lower()} is {fault.offered}, but {fault.requested} is requested"
        )
    return None


def silence(name: str, facts: Facts, requested: Mapping[str, object] | None = None) -> str | None:
    """Why no messages were received; `requested` is the QoS of the expectation."""
    publishers = [e for e in facts.endpoints(name) if e.is_publisher]
    if not publishers:
        return _gone_publisher(name, facts) or _missing_topic(name, facts) or "it has no publisher"
    trouble = next((text for text in facts.troubles if name in text), None)
    if trouble is not None:
        return trouble
    for publisher in publishers if requested else ():
        fault = next(iter(faults(publisher, _subscription(publisher, requested or {}))), None)
        if fault is not None:
            return (
                f"{publisher.node} publishes, but {fault.policy.lower()} is {fault.offered}, "
                f"while the expectation requests {fault.requested}"
            )
    for publisher in publishers:
        if publisher.node in facts.graph().ghosts:
            return f"the process of {publisher.node} is gone"
    return f"{publishers[0].node} has a publisher, but it published nothing"


def _subscription(publisher: Endpoint, requested: Mapping[str, object]) -> Endpoint:
    return Endpoint(
        topic=publisher.topic,
        node="the expectation",
        direction="subscription",
        type=publisher.type,
        reliability=str(requested.get("reliability", "BEST_EFFORT")).upper(),
        durability=str(requested.get("durability", "VOLATILE")).upper(),
        deadline_ns=INFINITE_NS,
        lease_ns=INFINITE_NS,
    )


def wrong_rate(name: str, facts: Facts, *, is_slow: bool) -> str | None:
    publishers = [e.node for e in facts.endpoints(name) if e.is_publisher]
    if not is_slow:
        several = f"{len(publishers)} publishers: {', '.join(sorted(publishers))}"
        return several if len(publishers) > 1 else None
    gone = _gone_publisher(name, facts)
    if gone is not None:
        return gone
    for node in publishers:
        process = facts.process_of(node)
        loads = [s.cpu_percent for s in facts.samples if s.process == process and s.cpu_percent]
        if loads and sum(loads) / len(loads) >= BUSY_PERCENT:
            return f"{process} was busy: {sum(loads) / len(loads):.0f} % of a core on average"
    return None


def missing_service(name: str, facts: Facts) -> str | None:
    if name in facts.services:
        return None
    if name.rpartition("/")[2] not in NODE_SERVICES:  # which are elsewhere for sure
        elsewhere = _elsewhere("service", name, sorted(facts.services))
        if elsewhere:
            return elsewhere
    similar = did_you_mean(name, facts.services)
    return f"no node offers it; {similar}" if similar else None


def unknown_process(pattern: str, facts: Facts) -> str | None:
    """That no process matches, with the names that there are."""
    if pattern in ("*", LAUNCHER) or facts.named(pattern):
        return None
    known = [name for name in facts.processes() if pattern in name] or facts.processes()
    return f"no process is named {pattern}; there are: {', '.join(known) or 'none'}"


def missing_line(
    wanted: re.Pattern[str], process: str | None, level: str | None, since_s: float, facts: Facts
) -> str | None:
    """Where such a line was printed instead: by another process, too early, or in other case."""
    reason = _quiet_process(process, facts)
    if reason is not None:
        return reason
    same = [one for one in facts.lines if wanted.search(one.plain)]
    of = [one for one in same if facts.is_from(one, process)]
    if of and of[-1].at_s < since_s:
        return f"it came before, at {of[-1].at_s:.1f} s of the run"
    if of:
        last = of[-1].level
        return None if level in (None, last) else f"its level is {last or 'unknown'}, not {level}"
    if same:
        return f"{same[-1].process or 'the launcher'} printed such a line, at {same[-1].at_s:.1f} s"
    any_case = re.compile(wanted.pattern, wanted.flags | re.IGNORECASE)
    other = [one for one in facts.lines if any_case.search(one.plain)]
    return f"a line differs in upper and lower case: {shorten(other[-1].plain)}" if other else None


def missing_message(topic: str, since_s: float, facts: Facts) -> str | None:
    received = facts.received(topic)
    if not received:
        return silence(topic, facts)
    last = received[-1]
    if last.at_s < since_s:
        return f"the last of {len(received)} messages came before, at {last.at_s:.1f} s of the run"
    shown = shorten(repr(last.content))
    return f"{len(received)} messages came, and none of them matches; the last one was {shown}"


def _quiet_process(pattern: str | None, facts: Facts) -> str | None:
    """Why a process printed nothing that matches."""
    if pattern in (None, "*", LAUNCHER):
        return None
    unknown = unknown_process(pattern, facts)
    if unknown is not None:
        return unknown
    names = facts.named(pattern)
    for name in names:
        ended = _ended(name, facts)
        if ended:
            return f"{name} {ended}"
    if not any(one.process in names for one in facts.lines):
        return f"{', '.join(names)} printed nothing"
    return None
