"""What one run has shown, from the facts about it."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from launcher.base.document.quantities import INFINITY
from launcher.base.model.run_events import Ended, Started
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph, is_hidden
from launcher.smoke.expect.expectation import READY
from launcher.smoke.observe.facts import Facts, GraphSeen, LogLine, label_of
from launcher.smoke.record.watched_run import begin_s, is_common

SEND_GOAL = "/_action/send_goal"
_NO_GRAPH = GraphSeen(at_s=0.0, snapshot=TopicGraph(nodes=(), endpoints=()))


@dataclass(frozen=True)
class ObservedRun:
    """`facts` are of a run that is over; `states` are those of its lifecycle nodes."""

    facts: Facts
    for_s: float
    states: Mapping[str, str] = field(default_factory=dict)

    @functools.cached_property
    def begin_s(self) -> float:
        """From then on nothing changed: the rates are of this time."""
        return begin_s(self.facts, self.for_s)

    @functools.cached_property
    def presence_s(self) -> float:
        """When all nodes and topics were there: another run is ready then."""
        first_s = min((e.at_s for e in self.facts.of(Started)), default=0.0)
        times_s = [self.node_since(name) for name in self.nodes]
        times_s += [self.topic_since(name) for name in self.topics]
        return max(times_s, default=first_s)

    def as_judged(self) -> Facts:
        """The facts for a judge, to whom `ready` is when everything was there."""
        return replace(self.facts, steps={**self.facts.steps, READY: self.begin_s})

    @functools.cached_property
    def graphs(self) -> tuple[GraphSeen, ...]:
        """At least one: a system may end before the first one is seen."""
        found = tuple(graph for graph in self.facts.graphs if graph.at_s <= self.facts.stop_s)
        return found or (_NO_GRAPH,)

    def since(self, describe: Callable[[GraphSeen], object]) -> float:
        """Since when `describe` returned what it returns of the last graph."""
        at_s = 0.0
        for graph in reversed(self.graphs):
            if describe(graph) != describe(self.graphs[-1]):
                break
            at_s = graph.at_s
        return at_s

    # ---- processes

    @functools.cached_property
    def pids(self) -> frozenset[int]:
        return frozenset(start.event.pid for start in self.facts.of(Started))

    @functools.cached_property
    def processes(self) -> dict[str, list[str]]:
        """Label -> the processes of that label."""
        found: dict[str, list[str]] = {}
        for name in self.facts.processes():
            found.setdefault(label_of(name), []).append(name)
        return found

    def are_alive(self, label: str) -> bool:
        stop_s = self.facts.stop_s
        return all(self.facts.was_running(name, stop_s) for name in self.processes[label])

    def ended_s(self, label: str) -> float | None:
        """When the last process of that label had exited; None unless all had, with 0."""
        ends = [self.facts.last_end(name) for name in self.processes[label]]
        if any(end is None or end.at_s > self.facts.stop_s for end in ends):
            return None
        codes = {end.event.returncode for end in ends if end is not None}
        return max(end.at_s for end in ends if end is not None) if codes == {0} else None

    def was_restarted(self, label: str) -> bool:
        ends = (e for name in self.processes[label] for e in self.facts.of(Ended, name))
        return any(end.event.restart_in_s is not None for end in ends)

    def memory_bytes(self, label: str) -> int:
        """The most of any process of that label; 0 if none was measured."""
        return max((size for _, size in self._sizes(label)), default=0)

    def measured_s(self, label: str) -> float:
        """When the memory of a process of that label was first known; INFINITY if it never was."""
        return min((at_s for at_s, _ in self._sizes(label)), default=INFINITY)

    def _sizes(self, label: str) -> Iterator[tuple[float, int]]:
        names = self.processes[label]
        for sample in self.facts.samples:
            if sample.process in names and sample.memory_bytes:
                yield sample.at_s, sample.memory_bytes

    def lines(self, label: str) -> list[LogLine]:
        names = self.processes[label]
        return [line for line in self.facts.lines if line.process in names]

    # ---- the graph

    @property
    def last(self) -> GraphSeen:
        return self.graphs[-1]

    @functools.cached_property
    def nodes(self) -> Counter[str]:
        """The nodes that are there at the end, and how many have each name."""
        ghosts = self.last.snapshot.ghosts
        names = (n for n in self.last.snapshot.nodes if n not in ghosts and not is_hidden(n))
        return Counter(names)

    def node_since(self, name: str) -> float:
        graphs = (g for g in self.graphs if name in g.snapshot.nodes)
        return next(graph.at_s for graph in graphs)

    @functools.cached_property
    def topics(self) -> dict[str, tuple[Endpoint, ...]]:
        """The endpoints of each topic that is not of every node."""
        found: dict[str, list[Endpoint]] = {}
        for end in self.last.snapshot.endpoints:
            if not is_common(end.topic):
                found.setdefault(end.topic, []).append(end)
        return {topic: tuple(ends) for topic, ends in found.items()}

    def topic_since(self, topic: str) -> float:
        return self.since(lambda graph: _counts(graph, topic))

    def counts(self, topic: str, *, publishers: bool) -> tuple[int, int]:
        """The least and the greatest number of endpoints while the run was watched."""
        begin_s, index = self.begin_s, 0 if publishers else 1
        before = [graph for graph in self.graphs if graph.at_s <= begin_s][-1:]
        watched = [*before, *(graph for graph in self.graphs if graph.at_s > begin_s)]
        numbers = [_counts(graph, topic)[index] for graph in watched]
        return min(numbers), max(numbers)

    @functools.cached_property
    def services(self) -> dict[str, tuple[str, ...]]:
        """The services, with their types; of actions only the one that begins it."""
        return {
            name: types
            for name, types in self.last.services.items()
            if name.endswith(SEND_GOAL) or not is_hidden(name)
        }

    def service_since(self, name: str) -> float:
        return self.since(lambda graph: graph.services.get(name))

    # ---- messages

    def message_times(self, topic: str) -> list[float]:
        """When messages were sent in the watched time; receivers on a busy machine are late."""
        messages = self.facts.received(topic)
        times = (m.at_s if m.sent_s is None else m.sent_s for m in messages)
        return sorted(at_s for at_s in times if self.begin_s <= at_s <= self.facts.stop_s)


def _counts(graph: GraphSeen, topic: str) -> tuple[int, int]:
    """How many publishers and subscriptions."""
    sides = [end.is_publisher for end in graph.snapshot.on(topic)]
    return sum(sides), len(sides) - sum(sides)
