"""Guesses: what the facts say about why an expectation was not met. No fact, no guess."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Mapping

from launcher.ros.snapshot.graph import INFINITE_NS, Endpoint
from launcher.ros.snapshot.qos_matching import faults, mismatches
from launcher.smoke.facts import Facts, LogLine
from launcher.smoke.fields import near

_SHOWN = 200  # characters of a message
BUSY_PERCENT = 90.0  # of one core: a Python node has no more


def processes_on(topic: str, facts: Facts) -> tuple[str, ...]:
    """The processes of the publishers of a topic."""
    nodes = [e.node for e in facts.endpoints(topic) if e.is_publisher]
    found = (facts.process_of(node) for node in nodes)
    return tuple(dict.fromkeys(name for name in found if name))[:2]


def death(process: str, facts: Facts) -> str | None:
    """Why a process may have died: the exception that it printed."""
    for one in reversed(facts.last_lines(process, 20)):
        head, colon, _ = one.plain.partition(":")
        if colon and head.rpartition(".")[2].endswith(("Error", "Exception")):
            return f"it raised {one.plain}"
    return None


def missing_node(node: str, facts: Facts) -> str | None:
    """Why a node never appeared."""
    process = facts.process_of(node)
    if process is None:
        return _no_process(node, facts)
    for event in facts.of("not started", process):
        return f"its process {process} could not be started: {event.details.get('reason')}"
    ends = list(facts.of("ended", process))
    if ends and not facts.lives(process, facts.stop_s):
        code = ends[-1].details.get("returncode")
        why = death(process, facts)
        reason = f"; {why}" if why else ""
        return f"its process {process} ended at {ends[-1].at_s:.1f} s (exit code {code}){reason}"
    if facts.graph().nodes:
        base = node.rpartition("/")[2]
        other = [n for n in facts.graph().nodes if n.rpartition("/")[2] == base]
        if other:
            return f"there is a node of that name elsewhere: {', '.join(other)}"
    return f"its process {process} ran, but told nobody about a node {node}"


def _no_process(node: str, facts: Facts) -> str | None:
    if not facts.processes():
        return "no process was started at all"
    known = list(facts.graph().nodes)
    similar = near(node, known)
    if similar and similar.startswith("did"):
        return f"no process of the launch file has this node; {similar}"
    base = [n for n in known if n.rpartition("/")[2] == node.rpartition("/")[2]]
    if base:
        return f"there is a node of that name elsewhere: {', '.join(base)}"
    return None


def topic(name: str, wanted_type: str | None, facts: Facts) -> str | None:
    """Why a topic is not as expected."""
    endpoints = facts.endpoints(name)
    types = {e.type: e.node for e in endpoints}
    if wanted_type and types and wanted_type not in types:
        found = ", ".join(f"{node} uses {kind}" for kind, node in types.items())
        return f"the topic has another type: {found}"
    if not endpoints:
        return _elsewhere(name, facts)
    return _gone_publisher(name, facts)


def _elsewhere(name: str, facts: Facts) -> str | None:
    known = [t for t in facts.graph().topics() if t not in ("/rosout", "/parameter_events")]
    base = [t for t in known if t.rpartition("/")[2] == name.rpartition("/")[2]]
    if base:
        return f"there is a topic of that name elsewhere: {', '.join(base)}"
    similar = near(name, known)
    return f"nobody has it; {similar}" if similar and similar.startswith("did") else None


def _gone_publisher(name: str, facts: Facts) -> str | None:
    """Somebody who published before and does not any more."""
    before = {
        e.node: seen.at_s for seen in facts.graphs for e in seen.snapshot.on(name) if e.is_publisher
    }
    now = {e.node for e in facts.endpoints(name) if e.is_publisher} - set(facts.graph().ghosts)
    for node in sorted(before.keys() - now):
        process = facts.process_of(node)
        died = list(facts.of("ended", process)) if process else []
        end = f": its process {process} ended at {died[-1].at_s:.1f} s" if died else ""
        return f"{node} published it and does not any more{end}"
    return None


def mismatch(name: str, facts: Facts) -> str | None:
    """Pairs on a topic that exchange nothing."""
    for found in mismatches(facts.endpoints(name)):
        fault = found.faults[0]
        return (
            f"{found.subscription.node} gets nothing from {found.publishers[0].node}: "
            f"{fault.policy.lower()} is {fault.offered}, but {fault.asked} is asked for"
        )
    return None


def silence(name: str, facts: Facts, asked: Mapping[str, object] | None = None) -> str | None:
    """Why nothing, or next to nothing, came on a topic."""
    publishers = [e for e in facts.endpoints(name) if e.is_publisher]
    if not publishers:
        return _gone_publisher(name, facts) or _elsewhere(name, facts) or "nobody publishes it"
    trouble = next((text for text in facts.troubles if name in text), None)
    if trouble is not None:
        return trouble
    for publisher in publishers if asked else ():
        fault = next(iter(faults(publisher, _subscription(publisher, asked or {}))), None)
        if fault is not None:
            return (
                f"{publisher.node} publishes, but {fault.policy.lower()} is {fault.offered}, "
                f"while the expectation asks for {fault.asked}"
            )
    for publisher in publishers:
        if publisher.node in facts.graph().ghosts:
            return f"the process of {publisher.node} is gone"
    return f"{publishers[0].node} has a publisher, but it published nothing"


def _subscription(publisher: Endpoint, asked: Mapping[str, object]) -> Endpoint:
    return Endpoint(
        topic=publisher.topic,
        node="the expectation",
        direction="subscription",
        type=publisher.type,
        reliability=str(asked.get("reliability", "BEST_EFFORT")).upper(),
        durability=str(asked.get("durability", "VOLATILE")).upper(),
        deadline_ns=INFINITE_NS,
        lease_ns=INFINITE_NS,
    )


def slow(name: str, facts: Facts, *, is_slow: bool) -> str | None:
    """Why a rate is too low or too high."""
    publishers = [e.node for e in facts.endpoints(name) if e.is_publisher]
    if not is_slow:
        if len(publishers) > 1:
            return f"{len(publishers)} publishers: {', '.join(sorted(publishers))}"
        return None
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
    """Why a service did not answer."""
    known = facts.services
    if name in known:
        return None
    base = [s for s in known if s.rpartition("/")[2] == name.rpartition("/")[2]]
    if base and not name.endswith(("/get_parameters", "/set_parameters")):
        return f"there is a service of that name elsewhere: {', '.join(sorted(base)[:3])}"
    similar = near(name, list(known))
    return f"nobody offers it; {similar}" if similar and similar.startswith("did") else None


def unknown(pattern: str, facts: Facts) -> str | None:
    """That no process is called so, and how those are called that there are."""
    if pattern in ("*", "launch") or facts.named(pattern):
        return None
    near_names = [n for n in facts.processes() if fnmatch.fnmatchcase(n, f"*{pattern}*")]
    known = ", ".join(near_names or facts.processes()) or "none"
    return f"no process is called {pattern}; there are: {known}"


def line(
    wanted: re.Pattern[str], process: str | None, level: str | None, since_s: float, facts: Facts
) -> str | None:
    """Why a line did not come: it came from somebody else, too early, or nearly as wanted."""
    reason = quiet_process(process, facts)
    if reason is not None:
        return reason
    same = [one for one in facts.lines if wanted.search(one.plain)]
    of = [one for one in same if _is_of(one, process, facts)]
    if of and of[-1].at_s < since_s:
        return f"it came before, at {of[-1].at_s:.1f} s of the run"
    if of:
        last = of[-1].level
        return None if level in (None, last) else f"its level is {last or 'unknown'}, not {level}"
    if same:
        return f"{same[-1].process or 'the launcher'} printed such a line, at {same[-1].at_s:.1f} s"
    careless = re.compile(wanted.pattern, wanted.flags | re.IGNORECASE)
    other = [one for one in facts.lines if careless.search(one.plain)]
    if other:
        return f"a line differs in upper and lower case: {other[-1].plain[:200]}"
    return None


def _is_of(one: LogLine, process: str | None, facts: Facts) -> bool:
    if one.process is None:
        return process == "launch"
    return process is None or facts.is_named(one.process, process)


def message(topic: str, since_s: float, facts: Facts) -> str | None:
    """Why no message came that fits."""
    heard = facts.heard(topic)
    if not heard:
        return silence(topic, facts)
    last = heard[-1]
    if last.at_s < since_s:
        return f"the last of {len(heard)} messages came before, at {last.at_s:.1f} s of the run"
    text = repr(last.content)
    shown = text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
    return f"{len(heard)} messages came, and none of them fits; the last one was {shown}"


def quiet_process(pattern: str | None, facts: Facts) -> str | None:
    """Why a process printed nothing that fits."""
    if pattern in (None, "*", "launch"):
        return None
    nobody = unknown(pattern, facts)
    if nobody is not None:
        return nobody
    names = facts.named(pattern)
    for name in names:
        ends = list(facts.of("ended", name))
        if ends and not facts.lives(name, facts.stop_s):
            why = death(name, facts)
            return f"{name} ended at {ends[-1].at_s:.1f} s" + (f"; {why}" if why else "")
    if not any(one.process in names for one in facts.lines):
        return f"{', '.join(names)} printed nothing at all"
    return None
