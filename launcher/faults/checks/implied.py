"""What every watched run expects, without a file: each check finds several faults."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from launcher.base.model.run_event import exit_text
from launcher.base.model.run_events import (
    Ended,
    NotResponding,
    NotStarted,
    Responds,
    Started,
)
from launcher.faults.checks.check import Check, Found, SubjectCheck, origin
from launcher.faults.model.fault import FaultFinding, FaultOrigin
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.machine_facts import MachineSample
from launcher.faults.watcher.story import CLOCK_STEP_S, Row, Story, is_here
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, TopicGraph, is_hidden
from launcher.smoke.observe.facts import matches

ALIVE_S = 3.0  # a process that runs so long again is well
GONE_S = 2.0
CLOCK_S = 5.0  # a step of the clock is over after this
LOW_BYTES, LOW_SHARE = 64 * 1024**2, 0.01  # of a disk: room for some minutes of logs
BOTH_SIDES_S = 3.0  # a topic that had both sides for so long is expected to have them
SLOWED = 0.3  # of the looks at a process found it suspended: somebody slows it down
PARTICIPANT = 35  # characters of a GID that are those of its participant

_Sides = dict[bool, set[str]]  # of a topic: processes; True is the side of publishers


class DeathCheck(SubjectCheck):
    """No process exits unexpectedly, or cannot be started."""

    kind, expected = "no deaths", "no process exits unexpectedly"
    debounce = Debounce(confirm_s=0.0, heal_s=0.0)
    names = ("no deaths: *",)

    def __init__(self, but: Collection[str] = ()) -> None:
        self._but = but  # patterns of those that are expected to exit
        self._open: dict[str, FaultFinding] = {}

    def find(self, story: Story) -> Mapping[str, FaultFinding]:
        for event in story.facts.events:
            name = event.process
            if name is None:
                continue
            if not event.event.is_failure:
                if isinstance(event.event, Ended):
                    self._open.pop(name, None)  # it has run again, and ended as it should
                continue
            row = story.row(name)
            nodes = () if row is None else tuple(row["node_names"])
            if any(matches(pattern, name, nodes) for pattern in self._but):
                continue
            self._open[name] = FaultFinding(
                seen=f"{name} {_end_text(event.event)}",
                processes=(name,),
                nodes=nodes,
                certain=True,
                settles=False,
                since_s=event.at_s,
            )
        for name, finding in tuple(self._open.items()):
            if story.rows_s > (died_s := finding.since_s or 0.0) + GONE_S and _is_well(
                story.row(name), story.rows_s, died_s
            ):
                del self._open[name]
        return self._open


def _is_well(row: Row | None, rows_s: float, died_s: float) -> bool:
    """Whether it has been running again for a while, or is of the run no more after a reload."""
    if row is None:
        return True
    uptime_s = row["uptime_s"] or 0.0
    return row["pid"] is not None and uptime_s >= ALIVE_S and rows_s - uptime_s > died_s - 1.0


def _end_text(event: object) -> str:
    if isinstance(event, Ended):
        return f"died ({exit_text(event.returncode)})"
    return f"could not be started: {event.reason}" if isinstance(event, NotStarted) else "failed"


class SuspensionCheck(SubjectCheck):
    """No process is suspended that nobody has paused."""

    kind, expected = "not suspended", "no process is suspended by a signal"
    debounce = Debounce(confirm_s=0.2, heal_s=1.0)
    names = ("not suspended: *",)

    def find(self, story: Story) -> Mapping[str, FaultFinding]:
        return {
            name: FaultFinding(seen=f"{name} {text}", processes=(name,))
            for row in story.rows
            if row["pid"] is not None
            and is_here(row)
            and (text := suspension_text(story, row["pid"]))
            and (name := str(row["name"])) not in story.paused_by_user
        }


def suspension_text(story: Story, pid: int) -> str:
    """How it is suspended, all the time or again and again; empty if it is not."""
    if story.stops.is_stopped(pid):
        return "is suspended (SIGSTOP)"
    share = story.stops.share(pid)
    is_slowed = share >= SLOWED and story.stops.alternates(pid)
    return f"is suspended again and again, {share:.0%} of the time" if is_slowed else ""


class ResponseCheck(Check):
    """Nodes answer, where that is watched (`--responsive`)."""

    debounce = Debounce(confirm_s=0.0, heal_s=0.0)
    names = ("responds: *",)

    def look(self, story: Story, known: Collection[str] = ()) -> Iterator[Found]:
        last = {
            event.process: event.event
            for event in story.facts.events
            if event.process is not None
            and isinstance(event.event, NotResponding | Responds | Started)
        }
        for name, event in last.items():
            finding = None
            if isinstance(event, NotResponding):
                seen = f"{name} has not answered for {event.silent_s:.0f} s"
                finding = FaultFinding(seen=seen, processes=(name,), certain=True, settles=False)
            yield Found(origin("responds", name, "the nodes of the process answer"), finding)


class DoubleCheck(SubjectCheck):
    """No two nodes have the same name."""

    kind, expected = "one node of a name", "no two nodes have the same name"
    debounce = Debounce(confirm_s=1.0, heal_s=2.0)
    names = ("one node of a name: *",)

    def find(self, story: Story) -> Mapping[str, FaultFinding] | None:
        document = story.document
        if not document:
            return None
        double = {
            node["name"]
            for node in document["nodes"]
            if node.get("count", 1) > 1 and not is_hidden(node["name"])
        }
        return {
            name: _double(story, name)
            for name in double
            if _participants(story, name) > 1 and story.process_of(name)
        }


def _double(story: Story, name: str) -> FaultFinding:
    ends = () if story.graph is None else story.graph.snapshot.endpoints
    own = [end.topic for end in ends if end.node == name and end.is_publisher]
    return FaultFinding(
        seen=f"there are several nodes {name}",
        nodes=(name,),
        processes=story.processes_of([name]),
        topics=tuple(dict.fromkeys(topic for topic in own if topic not in DEBUG_TOPICS)),
    )


def _participants(story: Story, node: str) -> int:
    """How many living participants have endpoints of this node."""
    ends = story.document.get("endpoints", ())
    living = (end for end in ends if end["node"] == node and not end.get("ghost"))
    return len({end["gid"][:PARTICIPANT] for end in living})


class QosCheck(SubjectCheck):
    """Every publisher matches every subscription of its topic; `but`: topics where not."""

    kind, expected = "QoS", "all publishers and subscriptions match"
    debounce = Debounce(confirm_s=0.7, heal_s=2.0)
    names = ("QoS: *",)

    def __init__(self, but: Collection[str] = ()) -> None:
        self._but = frozenset(but)

    def find(self, story: Story) -> Mapping[str, FaultFinding] | None:
        document = story.document
        if not document:
            return None
        found: dict[str, FaultFinding] = {}
        for one in document.get("mismatches", ()):
            topic = one["topic"]
            if topic in self._but or topic in found:
                continue
            nodes = tuple(dict.fromkeys([*one["publishers"], one["subscription"]]))
            processes = story.processes_of(nodes)
            if processes:  # else it is between programs that are not of this run
                found[topic] = FaultFinding(
                    seen=mismatch_text(one),
                    topics=(topic,),
                    nodes=nodes,
                    processes=processes,
                    settles=False,
                )
        return found


def mismatch_text(one: Mapping[str, Any]) -> str:
    """A mismatch as the probe reports it, in words."""
    fault = one["policies"][0]
    return (
        f"{one['subscription']} receives nothing from {one['publishers'][0]}: "
        f"{fault['policy'].lower()} is {fault['offered']}, but {fault['requested']} is requested"
    )


class SidesCheck(SubjectCheck):
    """A topic that nodes of the run published and received has both sides still."""

    kind, expected = "both sides", "a topic keeps its publishers and subscriptions"
    debounce = Debounce(confirm_s=2.0, heal_s=2.0)
    names = ("both sides: *",)

    def __init__(self) -> None:
        # From when to when it had both, and the processes of each.
        self._both: dict[str, tuple[float, float, _Sides]] = {}
        self._facts: tuple[object, object] = (None, None)  # that `_sides` is of
        self._sides: dict[str, _Sides] = {}
        self._has_looked = False

    def look(self, story: Story, known: Collection[str] = ()) -> Iterator[Found]:
        if not self._has_looked and story.graph is not None:
            self._has_looked = True
            for name in known:  # an earlier watcher has seen both
                kind, _, topic = name.partition(": ")
                if kind == self.kind:
                    self._both[topic] = -BOTH_SIDES_S, 0.0, {}
        yield from super().look(story, known)

    def find(self, story: Story) -> Mapping[str, FaultFinding] | None:
        graph = story.graph
        if graph is None:
            return None
        if self._facts[0] is not graph or self._facts[1] is not story.rows:
            self._facts = graph, story.rows
            self._sides = _sides(story, graph.snapshot)
        sides = self._sides
        # One that has neither side is no topic any more.
        self._both = {topic: span for topic, span in self._both.items() if topic in sides}
        lost: dict[str, FaultFinding] = {}
        for topic, found in sides.items():
            from_s, to_s, before = self._both.get(topic, (story.now_s, story.now_s, found))
            if len(found) == 2:
                self._both[topic] = from_s, story.now_s, found
            elif to_s - from_s < BOTH_SIDES_S or not _can_return(before, found, story):
                self._both.pop(topic, None)
            else:
                lost[topic] = _one_sided(story, topic, has_publisher=True in found)
        return lost


def _can_return(before: _Sides, now: _Sides, story: Story) -> bool:
    """Whether a process of the side that is missing is in the run; a reload may have dropped it."""
    (missing,) = {True, False} - now.keys()
    names = before.get(missing)
    return names is None or any(story.row(name) is not None for name in names)


def _sides(story: Story, graph: TopicGraph) -> dict[str, _Sides]:
    """By topic, the processes of the sides that nodes of the run have."""
    sides: dict[str, _Sides] = {}
    for end in graph.endpoints:
        process = None if end.node in graph.ghosts else story.process_of(end.node)
        if process and not is_hidden(end.topic) and end.topic not in DEBUG_TOPICS:
            sides.setdefault(end.topic, {}).setdefault(end.is_publisher, set()).add(process)
    return sides


def _one_sided(story: Story, topic: str, *, has_publisher: bool) -> FaultFinding:
    nodes = story.listeners(topic) if has_publisher else story.publishers(topic)
    return FaultFinding(
        seen=f"{topic} has no {'subscription' if has_publisher else 'publisher'} any more",
        topics=(topic,),
        nodes=nodes,
        processes=story.processes_of(nodes),
    )


class MachineCheck(Check):
    """The disk of the logs has room, and the clock is not set."""

    debounce = Debounce(confirm_s=0.0, heal_s=1.0)
    names = ("disk", "clock")

    def look(self, story: Story, known: Collection[str] = ()) -> Iterator[Found]:
        if not story.machine:
            return
        last = story.machine[-1]
        if last.free_bytes is not None and last.size_bytes:
            seen = f"{last.free_bytes / 1024**2:.0f} MiB are left on the disk of the log files"
            about = FaultOrigin(
                fault="disk",
                expectation="disk",
                kind="disk",
                expected="the disk of the log files has room",
            )
            full = FaultFinding(seen=seen, certain=True, settles=False)
            yield Found(about, full if is_full(last) else None)
        step = story.clock_step(story.now_s - CLOCK_S)
        about = FaultOrigin(
            fault="clock",
            expectation="clock",
            kind="clock",
            expected=f"the clock is not set by {CLOCK_STEP_S:g} s or more",
        )
        if step is None:
            yield Found(about, None)
        else:
            at_s, by_s = step
            seen = f"the clock was set {'forward' if by_s > 0 else 'back'} by {abs(by_s):.3g} s"
            finding = FaultFinding(
                seen=seen, value=by_s, unit="s", since_s=at_s, certain=True, settles=False
            )
            yield Found(about, finding)


def is_full(sample: MachineSample) -> bool:
    """Whether the disk of the log files has less room than it should."""
    free, size = sample.free_bytes, sample.size_bytes
    return free is not None and size is not None and free < min(LOW_BYTES, LOW_SHARE * size)


class HostCheck(SubjectCheck):
    """Other hosts of the run can be reached."""

    kind, expected = "reachable", "all hosts can be reached"
    debounce = Debounce(confirm_s=0.0, heal_s=0.5)
    names = ("reachable: *",)

    def find(self, story: Story) -> Mapping[str, FaultFinding]:
        found = {}
        for host, event in story.lost_hosts().items():
            why = f": {event.event.reason}" if event.event.reason else ""
            found[host] = FaultFinding(
                seen=f"host {host} is {event.event.state}{why}",
                processes=tuple(str(r["name"]) for r in story.rows if r.get("host") == host),
                since_s=event.at_s,
                certain=True,
                settles=False,
            )
        return found
