"""What is known of the last minutes of a run: what checks and causes are decided by."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from launcher.base.model.run_event import RunEvent
from launcher.base.model.run_events import Asked, Ended, LinkChanged, Started
from launcher.control.answer_lines import LOCAL
from launcher.faults.watcher.machine_facts import DelayWatch, MachineSample, StopWatch
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, Endpoint, is_hidden
from launcher.smoke.observe.facts import (
    Facts,
    GraphSeen,
    LogLine,
    ObservedMessage,
    ProcessEvent,
    label_of,
)

E = TypeVar("E", bound=RunEvent)

KEEP_S = 300.0  # of events
KEEP_ARRIVALS = 4000  # of one topic
KEEP_LINES = 3000
KEEP_SAMPLES = 300  # of one process, a second each
KEEP_GRAPHS = 20
KEEP_PUBLISHERS = 60  # graphs of which only the publishers are kept
BLIND_S = 5.0  # a new probe discovers the graph meanwhile
KEEP_MACHINE = 1200  # two in a second
KEEP_TRANSITS = 50  # messages
OTHER_CLOCK_S = 0.5  # no message takes so long from one host to another, unless clocks differ
LAST_LINES = 5
CLOCKS_DIFFER_S = 5.0  # a message is not on its way for longer
CLOCK_STEP_S = 0.1

Row = Mapping[str, Any]


@dataclass(slots=True)
class TopicArrivals:
    """When messages of a topic came: received and sent in time of the run, delays in seconds.

    A delay is from the stamp of the header, or from the publisher's time, to the reception.
    """

    received: deque[float] = field(default_factory=lambda: deque(maxlen=KEEP_ARRIVALS))
    transits: deque[float] = field(default_factory=lambda: deque(maxlen=KEEP_TRANSITS))
    sent: deque[float] = field(default_factory=lambda: deque(maxlen=KEEP_ARRIVALS))
    delays: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=KEEP_ARRIVALS))

    def add(self, received: Sequence[float], sent: Sequence[float]) -> None:
        """Messages that came and were sent at these times, the latter on the publisher's clock.

        If that is far from the clock of this machine, even for the quickest of the last messages,
        their times are taken back by as much.
        """
        self.received.extend(received)
        self.transits.extend(here - there for here, there in zip(received, sent, strict=True))
        shift_s = self.behind_s
        self.sent.extend(
            plausible_s(there + shift_s, here) for here, there in zip(received, sent, strict=True)
        )

    def note(self, message: ObservedMessage) -> None:
        """One that came with its content."""
        begin_s = message.stamp_s
        if begin_s is None:
            begin_s = plausible_s(message.sent_s, message.at_s)
        self.received.append(message.at_s)
        self.delays.append((message.at_s, message.at_s - begin_s))

    @property
    def behind_s(self) -> float:
        """How far the publisher's clock is behind that of this machine; 0 if it may be right."""
        quickest_s = min(self.transits, default=0.0)
        return quickest_s if abs(quickest_s) >= OTHER_CLOCK_S else 0.0

    def sent_since(self, from_s: float) -> list[float]:
        """Sorted, from this time on."""
        return sorted(_since(self.sent, from_s))

    def delays_since(self, from_s: float) -> list[float]:
        found = []
        for at_s, delay_s in reversed(self.delays):
            if at_s < from_s:
                break
            found.append(delay_s)
        return found


def plausible_s(sent_s: float | None, received_s: float) -> float:
    """When a message was sent, in time of the run, if that can be.

    The publisher's clock may be another one, and ours may have been set in between.
    """
    if sent_s is None or not 0.0 <= received_s - sent_s <= CLOCKS_DIFFER_S:
        return received_s
    return sent_s


def _since(times: deque[float], from_s: float) -> Iterator[float]:
    for at_s in reversed(times):
        if at_s < from_s - 1.0:  # they come nearly in order
            break
        if at_s >= from_s:
            yield at_s


def is_here(row: Row) -> bool:
    """Whether its process runs on this machine, where its pid means something."""
    return bool(row.get("host", LOCAL) == LOCAL)


class Story:
    """All `at_s` are in time of the run. `observer` is the pid of the probe."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.events: deque[ProcessEvent[RunEvent]] = deque(maxlen=5000)
        self.rows: Sequence[Row] = ()
        self.rows_s = 0.0  # when they were answered
        self.lines: deque[LogLine] = deque(maxlen=KEEP_LINES)
        self.graphs: deque[tuple[float, dict[str, Any]]] = deque(maxlen=KEEP_GRAPHS)
        self.arrivals: dict[str, TopicArrivals] = {}
        self.arrivals_s: float | None = None  # what came until then is among them
        # Of topics whose messages come with their content; by one subscription of each.
        self.received: dict[str, TopicArrivals] = {}
        self._watches: dict[str, str] = {}
        # When messages came that satisfy the conditions of an expectation, by its name.
        self.fitting: dict[str, deque[float]] = {}
        self.samples: dict[str, deque[tuple[float, float | None, int | None]]] = {}
        self.machine: deque[MachineSample] = deque(maxlen=KEEP_MACHINE)
        self.stops = StopWatch()
        self.delays = DelayWatch()
        self.observer: int | None = None
        self.facts = Facts()  # what is new since the last look
        self.is_stopping = False
        self.paused_by_user: set[str] = set()  # or under a debugger
        self._graph: GraphSeen | None = None
        self._sighted_s = 0.0  # from when on ROS is seen
        # For each of the last graphs, the publishers of each topic.
        self._published: deque[dict[str, list[str]]] = deque(maxlen=KEEP_PUBLISHERS)
        self._last_lines: dict[str, deque[LogLine]] = {}
        self._links: dict[str, ProcessEvent[LinkChanged]] = {}  # the last change of each
        self._rows: dict[str, Row] = {}
        self._of_node: dict[str, str] = {}  # process by the name of a node, as the launch file says
        self._of_pid: dict[int, str] = {}
        self._of_label: dict[str, str | None] = {}  # None: of several
        self._node_pids: dict[str, int | None] = {}

    def take(self, new: Facts) -> None:
        """Add what is new."""
        self.now_s, self.facts = new.now_s, new
        for event in new.events:
            self.events.append(event)
            if isinstance(event.event, Asked) and event.process is not None:
                if event.event.verb in ("pause", "debug"):
                    self.paused_by_user.add(event.process)
                elif event.event.verb == "resume":
                    self.paused_by_user.discard(event.process)
            if isinstance(event.event, LinkChanged):
                self._links[event.event.host] = event  # type: ignore[assignment]
        while self.events and self.events[0].at_s < self.now_s - KEEP_S:
            self.events.popleft()
        for line in new.lines:
            self.lines.append(line)
            if line.process is not None and line.plain.strip():
                last = self._last_lines.setdefault(line.process, deque(maxlen=LAST_LINES))
                last.append(line)
        for message in new.messages:
            if message.watch == self._watches.setdefault(message.topic, message.watch):
                self.received.setdefault(message.topic, TopicArrivals()).note(message)
        if new.graphs:
            self._graph = new.graphs[-1]

    def take_rows(self, rows: Sequence[Row], at_s: float) -> None:
        """What `ps` has answered."""
        self.rows, self.rows_s = rows, at_s
        self._rows = {row["name"]: row for row in rows}
        self._of_node, self._of_pid, self._of_label = {}, {}, {}
        for row in rows:
            name = row["name"]
            for node in row["node_names"]:
                self._of_node.setdefault(node, name)
            label = label_of(name)
            self._of_label[label] = None if label in self._of_label else name
            if row["pid"] is not None:
                if is_here(row):
                    self._of_pid.setdefault(row["pid"], name)
                found = self.samples.setdefault(row["name"], deque(maxlen=KEEP_SAMPLES))
                found.append((at_s, row["cpu_percent"], row["rss_bytes"]))
        self._forget_processes()

    def _forget_processes(self) -> None:
        """Forget those that a reload has dropped some minutes ago."""
        old_s = self.rows_s - KEEP_S
        for name in self.samples.keys() - self._rows.keys():
            if self.samples[name][-1][0] < old_s:
                del self.samples[name]
        for name in self._last_lines.keys() - self._rows.keys():
            if self._last_lines[name][-1].at_s < old_s:
                del self._last_lines[name]

    def take_graph(self, document: dict[str, Any], at_s: float) -> None:
        """A graph as the probe reports it."""
        self.graphs.append((at_s, document))
        self._node_pids = {one["name"]: one.get("pid") for one in document.get("nodes", ())}
        published: dict[str, list[str]] = {}
        for end in document.get("endpoints", ()):
            if end["direction"] == "publisher":
                published.setdefault(end["topic"], []).append(end["node"])
        self._published.append(published)

    def begin_blind(self) -> None:
        """There is a new probe: what it has not discovered yet is not missing."""
        self._sighted_s = self.now_s + BLIND_S
        self.arrivals.clear()
        self.arrivals_s = None

    @property
    def is_blind(self) -> bool:
        return self.now_s < self._sighted_s

    @property
    def graph(self) -> GraphSeen | None:
        """The last one; None before the first, and while a new probe discovers it."""
        return None if self.is_blind else self._graph

    @property
    def document(self) -> dict[str, Any]:
        """The same as the probe reports it; empty for none."""
        return self.graphs[-1][1] if self.graphs and not self.is_blind else {}

    # ---- processes

    def row(self, process: str) -> Row | None:
        return self._rows.get(process)

    def process_of(self, node: str) -> str | None:
        """The process of a node by its full name: as the launch file says, or by its pid."""
        if node in self._of_node:
            return self._of_node[node]
        pid = self._node_pids.get(node)
        if pid is not None:
            return self._of_pid.get(pid)
        return self._of_label.get(node.rpartition("/")[2])

    def processes_of(self, nodes: Iterable[str]) -> tuple[str, ...]:
        found = (self.process_of(node) for node in nodes)
        return tuple(dict.fromkeys(name for name in found if name))

    def of(
        self, kind: type[E], process: str | None = None, since_s: float = -KEEP_S
    ) -> list[ProcessEvent[E]]:
        """The events of a type since then, oldest first, of one process or of all."""
        return [
            event  # type: ignore[misc]
            for event in self.events
            if isinstance(event.event, kind)
            and process in (None, event.process)
            and event.at_s >= since_s
        ]

    def last(self, kind: type[E], process: str) -> ProcessEvent[E] | None:
        found = self.of(kind, process)
        return found[-1] if found else None

    def is_running(self, process: str) -> bool:
        row = self.row(process)
        return row is not None and row["state"] == "RUNNING"

    def was_asked(self, process: str, within_s: float) -> bool:
        """Whether a user, or the launch file, has requested its start or end in this time."""
        since_s = self.now_s - within_s
        asked = self.of(Asked, process, since_s) or self.of(Asked, None, since_s)
        if any(event.process in (None, process) for event in asked):
            return True
        return any(end.event.asked for end in self.of(Ended, process, since_s))

    def first_start_s(self, process: str) -> float | None:
        """When it was first started, as far as that is remembered."""
        starts = self.of(Started, process)
        return starts[0].at_s if starts and starts[0].event.restarts == 0 else None

    def lost_hosts(self) -> dict[str, ProcessEvent[LinkChanged]]:
        """The hosts that cannot be reached now, with the event that says so."""
        return {n: e for n, e in self._links.items() if e.event.state in ("unreachable", "gone")}

    def hosts_of(self, processes: Iterable[str]) -> dict[str, float]:
        """The other hosts of these processes, and for how long they were silent in the last row."""
        names = set(processes)
        rows = [row for row in self.rows if row["name"] in names and not is_here(row)]
        return {str(row["host"]): float(row.get("host_silent_s") or 0.0) for row in rows}

    def last_lines(self, processes: Iterable[str]) -> tuple[str, ...]:
        """The last lines of these, in order of time."""
        names = dict.fromkeys(processes)
        found = [line for name in names for line in self._last_lines.get(name, ())]
        found.sort(key=lambda line: line.at_s)
        return tuple(f"[{line.process}] {line.plain}" for line in found[-2 * LAST_LINES :])

    # ---- the graph

    def has_node(self, name: str) -> bool:
        return name in self._node_pids

    def endpoints(self, topic: str) -> list[Endpoint]:
        """Those of processes that run."""
        if self.graph is None:
            return []
        ghosts = self.graph.snapshot.ghosts
        return [e for e in self.graph.snapshot.on(topic) if e.node not in ghosts]

    def publishers(self, topic: str) -> tuple[str, ...]:
        """Nodes that publish it, now or at any time that is remembered, the present ones first."""
        now = [e.node for e in self.endpoints(topic) if e.is_publisher]
        before = (node for one in reversed(self._published) for node in one.get(topic, ()))
        return tuple(dict.fromkeys([*now, *before]))

    def listeners(self, topic: str) -> tuple[str, ...]:
        """Nodes that subscribe to it, or have as far as is remembered, the last ones first."""
        found = (
            end["node"]
            for _, document in reversed(self.graphs)
            for end in document.get("endpoints", ())
            if end["topic"] == topic and end["direction"] == "subscription"
        )
        return tuple(dict.fromkeys(found))

    def subscribers(self, topics: Iterable[str]) -> set[str]:
        """The nodes that subscribe to one of these."""
        wanted = set(topics)
        if self.graph is None:
            return set()
        ends = self.graph.snapshot.endpoints
        return {e.node for e in ends if not e.is_publisher and e.topic in wanted}

    def heard_by(self, processes: Iterable[str]) -> set[str]:
        """The topics that nodes of these processes subscribe to, but for hidden and debug ones."""
        names = set(processes)
        if self.graph is None or not names:
            return set()
        return {
            end.topic
            for end in self.graph.snapshot.endpoints
            if not end.is_publisher
            and not is_hidden(end.topic)
            and end.topic not in DEBUG_TOPICS
            and self.process_of(end.node) in names
        }

    def feeders(self, processes: Sequence[str]) -> tuple[str, ...]:
        """Other processes whose nodes publish what nodes of these listen to, now or before."""
        nodes = (node for topic in self.heard_by(processes) for node in self.publishers(topic))
        return tuple(name for name in self.processes_of(nodes) if name not in processes)

    def published_by(self, processes: Iterable[str]) -> set[str]:
        """The topics that nodes of these processes publish, or have published."""
        names = set(processes)
        pairs = {(t, n) for one in self._published for t, nodes in one.items() for n in nodes}
        ours = {node for node in {n for _, n in pairs} if self.process_of(node) in names}
        return {topic for topic, node in pairs if node in ours}

    # ---- the machine

    def clock_step(self, since_s: float) -> tuple[float, float] | None:
        """(time, seconds) of the last step of the clock since then; a slow correction is none."""
        for sample, before in itertools.pairwise(reversed(self.machine)):
            if sample.at_s < since_s:
                break
            step_s = sample.clock_s - before.clock_s
            if abs(step_s) >= CLOCK_STEP_S:
                return sample.at_s, step_s
        return None

    def pressure(self, resource: str, since_s: float) -> float | None:
        """The mean since then, 0 to 1; None where the kernel does not say."""
        found = [s.pressure[resource] for s in self.machine if s.at_s >= since_s and s.pressure]
        return sum(found) / len(found) if found else None
