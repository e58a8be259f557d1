"""What every watched run expects, without a file: each check finds several faults."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from launcher.base.model.run_event import exit_text
from launcher.base.model.run_events import Ended, NotResponding, NotStarted, Responds, Started
from launcher.faults.checks.check import Check, Found
from launcher.faults.model.fault import FaultOrigin, Finding
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import CLOCK_STEP_S, Story, is_here
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, is_hidden

ALIVE_S = 3.0  # a process that runs so long again is well
GONE_S = 2.0
CLOCK_S = 5.0  # a step of the clock is over after this
LOW_BYTES, LOW_SHARE = 64 * 1024**2, 0.01  # of a disk: room for some minutes of logs
BOTH_SIDES_S = 3.0  # a topic that had both sides for so long is expected to have them
SLOWED = 0.3  # of the looks at a process found it suspended: somebody slows it down
PARTICIPANT = 35  # characters of a GID that are those of its participant


def origin(kind: str, about: str, expected: str) -> FaultOrigin:
    return FaultOrigin(fault=f"{kind}: {about}", expectation=kind, kind=kind, expected=expected)


class DeathCheck(Check):
    """No process exits unexpectedly, or cannot be started."""

    debounce = Debounce(confirm_s=0.0, heal_s=0.0)
    names = ("no deaths: *",)

    def __init__(self, but: Collection[str] = ()) -> None:
        self._but = but  # patterns of those that are expected to exit
        self._open: dict[str, Finding] = {}

    def look(self, story: Story) -> Iterator[Found]:
        from launcher.smoke.observe.facts import matches

        for event in story.facts.events:
            name = event.process
            if name is None or not event.event.is_failure:
                continue
            row = story.row(name)
            nodes = () if row is None else tuple(row["node_names"])
            if any(matches(pattern, name, nodes) for pattern in self._but):
                continue
            seen = _end_text(event.event)
            self._open[name] = Finding(
                seen=f"{name} {seen}",
                processes=(name,),
                nodes=nodes,
                certain=True,
                since_s=event.at_s,
            )
        for name, finding in tuple(self._open.items()):
            is_well = self._is_well(story, name)
            found = origin("no deaths", name, "no process exits unexpectedly")
            if is_well:
                del self._open[name]
            yield Found(found, None if is_well else finding)

    def _is_well(self, story: Story, name: str) -> bool:
        """Whether it has been running again for a while, was stopped, or is of the run no more."""
        died_s = self._open[name].since_s or 0.0
        if story.rows_s > died_s + GONE_S and story.row(name) is None:
            return True  # a reload has dropped it
        ends = story.of(Ended, name, died_s)
        starts = story.of(Started, name, died_s)
        if ends and ends[-1].event.asked:
            return True
        is_last = bool(starts) and (not ends or starts[-1].at_s >= ends[-1].at_s)
        return is_last and story.now_s - starts[-1].at_s >= ALIVE_S


def _end_text(event: object) -> str:
    if isinstance(event, Ended):
        return f"died ({exit_text(event.returncode)})"
    return f"could not be started: {event.reason}" if isinstance(event, NotStarted) else "failed"


class SuspensionCheck(Check):
    """No process is suspended that nobody has paused."""

    debounce = Debounce(confirm_s=0.2, heal_s=1.0)
    names = ("not suspended: *",)

    def __init__(self) -> None:
        self._seen: set[str] = set()

    def look(self, story: Story) -> Iterator[Found]:
        found = {
            str(row["name"]): text
            for row in story.rows
            if row["pid"] is not None
            and is_here(row)
            and not _is_paused_by_user(story, row["name"])
            and (text := _suspended_text(story, row["pid"]))
        }
        for name in sorted(found.keys() | self._seen):
            about = origin("not suspended", name, "no process is suspended by a signal")
            finding = Finding(seen=f"{name} {found.get(name)}", processes=(name,))
            yield Found(about, finding if name in found else None)
        self._seen |= found.keys()


def _suspended_text(story: Story, pid: int) -> str:
    """How it is suspended, all the time or again and again; empty if it is not."""
    if story.stops.is_stopped(pid):
        return "is suspended (SIGSTOP)"
    share = story.stops.share(pid)
    return f"is suspended again and again, {share:.0%} of the time" if share >= SLOWED else ""


def _is_paused_by_user(story: Story, process: str) -> bool:
    from launcher.base.model.run_events import Asked

    asked = [e for e in story.of(Asked, process) if e.event.verb in ("pause", "resume", "debug")]
    return bool(asked) and asked[-1].event.verb != "resume"


class ResponseCheck(Check):
    """Nodes answer, where that is watched (`--responsive`)."""

    debounce = Debounce(confirm_s=0.0, heal_s=0.0)
    names = ("responds: *",)

    def look(self, story: Story) -> Iterator[Found]:
        for event in story.facts.events:
            if event.process is None:
                continue
            about = origin("responds", event.process, "the nodes of the process answer")
            match event.event:
                case NotResponding(silent_s):
                    seen = f"{event.process} has not answered for {silent_s:.0f} s"
                    yield Found(about, Finding(seen=seen, processes=(event.process,), certain=True))
                case Responds() | Started():
                    yield Found(about, None)


class DoubleCheck(Check):
    """No two nodes have the same name."""

    debounce = Debounce(confirm_s=1.0, heal_s=2.0)
    names = ("one node of a name: *",)

    def __init__(self) -> None:
        self._seen: set[str] = set()

    def look(self, story: Story) -> Iterator[Found]:
        document = story.document
        if not document:
            return
        double = {
            node["name"]
            for node in document["nodes"]
            if node.get("count", 1) > 1 and not is_hidden(node["name"])
        }
        double = {name for name in double if _participants(story, name) != 1}
        for name in sorted(double | self._seen):
            about = origin("one node of a name", name, "no two nodes have the same name")
            finding = Finding(
                seen=f"there are several nodes {name}",
                nodes=(name,),
                processes=story.processes_of([name]),
                topics=tuple(
                    e.topic
                    for e in (() if story.graph is None else story.graph.snapshot.endpoints)
                    if e.node == name and e.is_publisher and e.topic not in DEBUG_TOPICS
                ),
            )
            yield Found(about, finding if name in double else None)
        self._seen = double | self._seen


def _participants(story: Story, node: str) -> int:
    """How many living participants have endpoints of this node."""
    ends = story.document.get("endpoints", ())
    living = (end for end in ends if end["node"] == node and not end.get("ghost"))
    return len({end["gid"][:PARTICIPANT] for end in living})


class QosCheck(Check):
    """Every publisher matches every subscription of its topic; `but`: topics where not."""

    debounce = Debounce(confirm_s=0.7, heal_s=2.0)
    names = ("QoS: *",)

    def __init__(self, but: Collection[str] = ()) -> None:
        self._but = frozenset(but)
        self._seen: set[str] = set()

    def look(self, story: Story) -> Iterator[Found]:
        document = story.document
        if not document:
            return
        found: dict[str, Finding] = {}
        for one in document.get("mismatches", ()):
            topic = one["topic"]
            if topic in self._but or topic in found:
                continue
            nodes = tuple(dict.fromkeys([*one["publishers"], one["subscription"]]))
            found[topic] = Finding(
                seen=mismatch_text(one),
                topics=(topic,),
                nodes=nodes,
                processes=story.processes_of(nodes),
                settles=False,
            )
        for topic in sorted(found.keys() | self._seen):
            expected = "all publishers and subscriptions match"
            yield Found(origin("QoS", topic, expected), found.get(topic))
        self._seen |= found.keys()


def mismatch_text(one: Mapping[str, Any]) -> str:
    """A mismatch as the probe reports it, in words."""
    fault = one["policies"][0]
    return (
        f"{one['subscription']} receives nothing from {one['publishers'][0]}: "
        f"{fault['policy'].lower()} is {fault['offered']}, but {fault['requested']} is requested"
    )


class SidesCheck(Check):
    """A topic that nodes of the run published and received has both sides still."""

    debounce = Debounce(confirm_s=2.0, heal_s=2.0)
    names = ("both sides: *",)

    def __init__(self) -> None:
        self._both: dict[str, float] = {}  # since when it had both
        self._seen: set[str] = set()

    def look(self, story: Story) -> Iterator[Found]:
        if story.graph is None:
            return
        sides: dict[str, set[bool]] = {}
        for end in story.graph.snapshot.endpoints:
            is_ours = end.node not in story.graph.snapshot.ghosts and story.process_of(end.node)
            if is_ours and not is_hidden(end.topic) and end.topic not in DEBUG_TOPICS:
                sides.setdefault(end.topic, set()).add(end.is_publisher)
        lost: dict[str, Finding] = {}
        for topic, found in sides.items():
            if len(found) == 2:
                self._both.setdefault(topic, story.now_s)
            elif story.now_s - self._both.get(topic, story.now_s) >= BOTH_SIDES_S:
                side = "subscription" if True in found else "publisher"
                nodes = story.publishers(topic) if side == "publisher" else ()
                lost[topic] = Finding(
                    seen=f"{topic} has no {side} any more",
                    topics=(topic,),
                    nodes=nodes,
                    processes=story.processes_of(nodes),
                )
        for topic in sorted(lost.keys() | self._seen):
            about = origin("both sides", topic, "a topic keeps its publishers and subscriptions")
            yield Found(about, lost.get(topic))
        self._seen |= lost.keys()


class MachineCheck(Check):
    """The disk of the logs has room, and the clock is not set."""

    debounce = Debounce(confirm_s=0.0, heal_s=1.0)
    names = ("disk", "clock")

    def look(self, story: Story) -> Iterator[Found]:
        if not story.machine:
            return
        last = story.machine[-1]
        if last.free_bytes is not None and last.size_bytes:
            is_low = last.free_bytes < min(LOW_BYTES, LOW_SHARE * last.size_bytes)
            seen = f"{last.free_bytes / 1024**2:.0f} MiB are left on the disk of the log files"
            about = FaultOrigin(
                fault="disk",
                expectation="disk",
                kind="disk",
                expected="the disk of the log files has room",
            )
            yield Found(about, Finding(seen=seen, certain=True) if is_low else None)
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
            yield Found(about, Finding(seen=seen, value=by_s, unit="s", since_s=at_s, certain=True))


class HostCheck(Check):
    """Other hosts of the run can be reached."""

    debounce = Debounce(confirm_s=0.0, heal_s=0.5)
    names = ("reachable: *",)

    def __init__(self) -> None:
        self._seen: set[str] = set()

    def look(self, story: Story) -> Iterator[Found]:
        lost = story.lost_hosts()
        for host in sorted(lost.keys() | self._seen):
            about = origin("reachable", host, "all hosts can be reached")
            finding = None
            if host in lost:
                event = lost[host]
                why = f": {event.event.reason}" if event.event.reason else ""
                names = tuple(str(r["name"]) for r in story.rows if r.get("host") == host)
                finding = Finding(
                    seen=f"host {host} is {event.event.state}{why}",
                    processes=names,
                    since_s=event.at_s,
                    certain=True,
                )
            yield Found(about, finding)
        self._seen |= lost.keys()
