"""The rules about processes and nodes, and the order of all: from those that explain all faults to
those that explain one.

Each has the fault and the story of the last minutes, and returns a cause or None. A cause comes
before its fault; `first_s` is when the fault was first seen, which may be a moment before the
cause was: lines, events and messages arrive by different ways.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from launcher.base.document.quantities import seconds_text
from launcher.base.model.run_event import RunEvent, exit_text
from launcher.base.model.run_events import Asked, Ended, NotStarted, Started
from launcher.base.text import several
from launcher.faults.causes.cause import BEFORE_S, LATER_S, OF_TIME, Cause
from launcher.faults.causes.machine_rules import (
    clock_step,
    full_disk,
    lost_link,
    other_clock,
    starvation,
)
from launcher.faults.checks.implied import mismatch_text, suspension_text
from launcher.faults.model.fault import Fault
from launcher.faults.watcher.story import Story, is_here
from launcher.smoke.observe.facts import ProcessEvent

AFTER_START_S = 5.0  # so long after a start a fault may be due to it: discovery, windows of rates
BUSY_PERCENT = 90.0  # of a core

Rule = Callable[[Fault, Story], "Cause | None"]


def request_of_a_user(fault: Fault, story: Story) -> Cause | None:
    """A user has stopped or paused the process."""
    for name in fault.finding.processes:
        row = story.row(name)
        asked = story.of(Asked, name)
        if not asked or row is None or asked[-1].at_s > fault.life.first_s + LATER_S:
            continue
        verb = asked[-1].event.verb
        is_paused = verb == "pause" and row["paused"]
        is_stopped = verb in ("stop", "kill") and not story.of(Started, name, asked[-1].at_s)
        if is_paused or (is_stopped and row["pid"] is None):
            done = {"stop": "stopped", "kill": "killed", "pause": "paused"}[verb]
            return Cause(
                rule="request",
                text=f"a user has {done} {name}",
                at_s=asked[-1].at_s,
                about=frozenset({name}),
            )
    return None


def death(fault: Fault, story: Story) -> Cause | None:
    """A process has died, or could not be started, and is what the fault is about."""
    for name, at_s, text in _deaths(fault, story):
        is_again = bool(story.of(Started, name, at_s))
        more = ", and was started again" if is_again and fault.origin.kind != "no deaths" else ""
        return Cause(
            rule="death",
            text=f"{name} {text}{more}",
            at_s=at_s,
            about=frozenset({name}),
        )
    return None


def _deaths(fault: Fault, story: Story) -> Iterator[tuple[str, float, str]]:
    """(process, time, text) of the last deaths that come before the fault, the newest first."""
    names = set(fault.finding.processes)
    latest_s = fault.life.first_s + LATER_S
    for event in reversed(story.events):
        if event.process not in names or not event.event.is_failure or event.at_s > latest_s:
            continue
        if _is_over(event, fault, story):
            continue
        if isinstance(event.event, Ended):
            yield str(event.process), event.at_s, f"died ({exit_text(event.event.returncode)})"
        elif isinstance(event.event, NotStarted):
            yield str(event.process), event.at_s, f"could not be started: {event.event.reason}"


def _is_over(death: ProcessEvent[RunEvent], fault: Fault, story: Story) -> bool:
    """Whether the process had been running again for some time when the fault was first seen."""
    starts = story.of(Started, death.process, death.at_s)
    return bool(starts) and fault.life.first_s > starts[0].at_s + AFTER_START_S


def suspension(fault: Fault, story: Story) -> Cause | None:
    """A process is suspended by a signal, all the time or again and again."""
    for name in fault.finding.processes:
        row = story.row(name)
        if row is None or row["pid"] is None or not is_here(row):
            continue
        if text := suspension_text(story, row["pid"]):
            about = frozenset({name})
            cause = Cause(
                rule="slow process", text=f"{name} {text}", at_s=fault.life.first_s, about=about
            )
            is_stopped = story.stops.is_stopped(row["pid"])
            return replace(cause, rule="suspension") if is_stopped else cause
    return None


def double_node(fault: Fault, story: Story) -> Cause | None:
    """Two nodes have one name: both publish, both answer."""
    document = story.document
    double = {
        node["name"]
        for node in document.get("nodes", ())
        if node.get("count", 1) > 1 and node["name"] in fault.finding.nodes
    }
    if not double or fault.origin.kind in ("no deaths", "qos", "QoS"):
        return None
    name = min(double)
    text = f"there are several nodes {name}: a program was started twice"
    return Cause(rule="double node", text=text, at_s=fault.life.first_s, about=frozenset({name}))


def qos_mismatch(fault: Fault, story: Story) -> Cause | None:
    """QoS keeps endpoints apart, perhaps since a restart."""
    topics = set(fault.finding.topics)
    is_of_arrival = fault.origin.kind in ("rate", "gap", "topic", "qos", "QoS", "both sides")
    if not is_of_arrival or (
        fault.origin.kind == "rate" and fault.finding.value not in (0.0, None)
    ):
        return None  # something arrives
    for one in story.document.get("mismatches", ()):
        if one["topic"] not in topics:
            continue
        nodes = [*one["publishers"], one["subscription"]]
        restarts = [
            event
            for name in story.processes_of(nodes)
            for event in story.of(Started, name, fault.life.first_s - BEFORE_S)
            if story.first_start_s(name) != event.at_s
        ]
        since = f" since the restart of {restarts[-1].process}" if restarts else ""
        return Cause(
            rule="QoS",
            text=f"{mismatch_text(one)}{since}",
            at_s=restarts[-1].at_s if restarts else fault.life.first_s,
            about=frozenset({one["topic"]}),
        )
    return None


def restart(fault: Fault, story: Story) -> Cause | None:
    """A process was restarted: what it publishes pauses meanwhile."""
    for name in fault.finding.processes:
        starts = [
            event
            for event in story.of(Started, name, fault.life.first_s - AFTER_START_S)
            if event.at_s <= fault.life.first_s + LATER_S
            and (event.event.restarts or story.first_start_s(name) != event.at_s)
        ]
        if starts and fault.origin.kind not in ("memory", "cpu"):
            ago_s = max(0.0, fault.life.first_s - starts[-1].at_s)
            text = f"{name} was restarted {seconds_text(ago_s)} before"
            return Cause(rule="restart", text=text, at_s=starts[-1].at_s, about=frozenset({name}))
    return None


def busy_process(fault: Fault, story: Story) -> Cause | None:
    """The process uses all of a core, which is all that Python can use."""
    for name in fault.finding.processes:
        loads = [cpu for at_s, cpu, _ in story.samples.get(name, ()) if cpu is not None][-3:]
        if len(loads) == 3 and sum(loads) / 3 >= BUSY_PERCENT:
            text = f"{name} is busy: {sum(loads) / 3:.0f} % of a core"
            return Cause(
                rule="busy process", text=text, at_s=fault.life.first_s, about=frozenset({name})
            )
    return None


def growth(fault: Fault, story: Story) -> Cause | None:
    """The memory of a process grows."""
    if fault.origin.kind != "memory" or not fault.finding.processes:
        return None
    name = fault.finding.processes[0]
    text = f"the memory of {fault.finding.seen}" if "grown" in fault.finding.seen else ""
    text = text or f"{name} needs more memory than expected"
    text = f"{text}: it seems to leak" if "grown" in fault.finding.seen else text
    return Cause(rule="growth", text=text, at_s=fault.life.first_s, about=frozenset({name}))


def wrong_value(fault: Fault, story: Story) -> Cause | None:
    """A value is not as expected, and the process that has it runs."""
    if fault.origin.kind not in ("parameter", "message"):
        return None
    who = several(fault.finding.nodes) or "a node"
    what = "has another value" if fault.origin.kind == "parameter" else "publishes wrong values"
    text = f"{who} {what}: {fault.finding.seen}"
    about = frozenset(fault.finding.processes or fault.finding.nodes)
    return Cause(rule="wrong value", text=text, at_s=fault.life.first_s, about=about)


def upstream(fault: Fault, story: Story) -> Cause | None:
    """A process that it listens to was stopped or restarted, or has died."""
    feeders = story.feeders(fault.finding.processes)
    if fault.origin.kind not in OF_TIME or not feeders:
        return None
    of_feeders = replace(fault, finding=replace(fault.finding, processes=feeders, nodes=()))
    for rule in (request_of_a_user, suspension, death, restart):
        cause = rule(of_feeders, story)
        if cause is not None and cause.at_s >= fault.life.first_s - BEFORE_S:
            return Cause(
                rule="upstream",
                text=f"{cause.text}; {several(fault.finding.processes)} listens to it",
                at_s=cause.at_s,
                about=cause.about,
                is_weak=True,
            )
    return None


def own_rate(fault: Fault, story: Story) -> Cause | None:
    """The publisher runs, the machine has time: it publishes less, more or late by itself."""
    names = [name for name in fault.finding.processes if story.is_running(name)]
    if fault.origin.kind not in OF_TIME or not names:
        return None
    topic, value = several(fault.finding.topics), fault.finding.value
    if fault.origin.kind == "latency":
        how = f"what comes on {topic} is late"
    elif fault.origin.kind == "rate" and value:
        how = f"publishes {topic} at {value:.3g} Hz"
    else:
        how = f"publishes nothing on {topic}"
    text = f"{several(names)} runs, and {how}: nothing else is unusual"
    return Cause(
        rule="publisher",
        text=text,
        at_s=fault.life.first_s,
        about=frozenset(names),
        is_weak=True,
    )


def guess(fault: Fault, story: Story) -> Cause | None:
    """What the judge of smoke supposes."""
    text = fault.finding.guess
    if text is None:
        return None
    about = frozenset((*fault.finding.processes, *fault.finding.topics))
    return Cause(rule="guess", text=text, at_s=fault.life.first_s, about=about, is_weak=True)


RULES: tuple[Rule, ...] = (
    clock_step,
    full_disk,
    lost_link,
    other_clock,
    request_of_a_user,
    suspension,
    double_node,
    qos_mismatch,
    death,
    restart,
    busy_process,
    starvation,
    growth,
    wrong_value,
    upstream,
    guess,
    own_rate,
)


def cause_of(fault: Fault, story: Story) -> Cause | None:
    """That of the first rule that explains it."""
    return next((found for rule in RULES if (found := rule(fault, story)) is not None), None)
