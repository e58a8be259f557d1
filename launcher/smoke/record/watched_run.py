"""A run that is only watched: until nothing changes any more, and then for a while."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from launcher.base.document.quantities import INFINITY
from launcher.base.document.source_location import Origin
from launcher.base.errors import LauncherError
from launcher.base.model.run_events import Started
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, is_hidden
from launcher.smoke.expect.expectation import START, Expectation
from launcher.smoke.expect.script import Script
from launcher.smoke.observe.facts import Facts, GraphSeen
from launcher.smoke.preflight.forecast import Forecast
from launcher.smoke.run.pending_starts import unstarted
from launcher.smoke.run.runner import Runner
from launcher.smoke.run.smoke_progress import SmokeProgress

QUIET_S = 3.0  # without a change, a system has come up
NODE_S = 20.0  # for the node of a process, on a busy machine; some have none of their name
ANSWER_S = 3.0
GET_STATE = "lifecycle_msgs/srv/GetState"
# The probe decodes what it receives; of these, megabytes a second.
HEAVY_TYPES = frozenset(
    f"sensor_msgs/msg/{name}" for name in ("Image", "PointCloud", "PointCloud2")
) | {"nav_msgs/msg/OccupancyGrid", "map_msgs/msg/OccupancyGridUpdate"}
OF_A_RECORDING = Origin(text="expected of a run that is recorded")


def script_of(for_s: float, ready_within_s: float) -> Script:
    """What a healthy run does: it logs no error. That nothing exits is expected of every run."""
    health = [
        Expectation(kind=kind, subject="*", implicit=True, origin=OF_A_RECORDING)
        for kind in ("no_errors", "no_tracebacks")
    ]
    return Script(expectations=tuple(health), for_s=for_s, ready_within_s=ready_within_s)


def is_heavy(types: Sequence[str]) -> bool:
    return not HEAVY_TYPES.isdisjoint(types)


def is_common(topic: str) -> bool:
    """Whether the topic is of every node, or hidden."""
    return topic in DEBUG_TOPICS or is_hidden(topic)


def changed_s(facts: Facts) -> float:
    """When a node, an endpoint or a service last came or went, or a process was started."""
    at_s = max((event.at_s for event in facts.of(Started)), default=0.0)
    graphs = [graph for graph in facts.graphs if graph.at_s <= facts.stop_s]
    since_s = 0.0
    for graph in reversed(graphs):
        if _content(graph) != _content(graphs[-1]):
            break
        since_s = graph.at_s
    return max(at_s, since_s)


def _content(graph: GraphSeen) -> object:
    snapshot = graph.snapshot
    nodes = Counter(name for name in snapshot.nodes if name not in snapshot.ghosts)
    ends = Counter((e.topic, e.node, e.direction) for e in snapshot.endpoints)
    return nodes, ends, frozenset(graph.services)


def _accept(forecast: Forecast) -> None:
    """Whatever is started is recorded."""


class RecordedRunner(Runner):
    """A run without expectations but its health; `states` are those of lifecycle nodes."""

    def __init__(
        self,
        script: Script,
        words: Sequence[str],
        folder: Path,
        progress: SmokeProgress,
    ) -> None:
        super().__init__(script, words, folder, progress, judge=_accept, always_probed=True)
        self._subscribed: set[str] = set()
        self.states: dict[str, str] = {}

    def _is_ready(self, facts: Facts) -> bool:
        """Some systems never stop changing; what is steady of them can be recorded."""
        is_quiet = facts.now_s - changed_s(facts) >= QUIET_S and not self._awaited_nodes(facts)
        is_late = facts.now_s > self._script.ready_limit_s()
        return (is_quiet or is_late) and not self._awaited_starts(facts)

    def _unready_text(self, facts: Facts) -> str:
        return f"; not started: {', '.join(self._awaited_starts(facts))}"

    def _awaited_starts(self, facts: Facts) -> list[str]:
        """Processes that timers of the launch file will start in time."""
        forecast, limit_s = self.forecast, self._script.ready_limit_s()
        if forecast is None:
            return []
        return [
            process.label
            for process, moment in unstarted(forecast, facts)
            if moment.time_s is not None and moment.time_s < limit_s
        ]

    def _awaited_nodes(self, facts: Facts) -> bool:
        """Whether a process that was started lately has not made its node."""
        nodes = facts.graph().nodes
        young = {e.process for e in facts.of(Started) if e.at_s > facts.now_s - NODE_S}
        return any(
            node not in nodes
            for process in young
            if process is not None and facts.was_running(process, facts.now_s)
            for node in facts.node_names.get(process, ())
        )

    def _end_s(self, facts: Facts) -> float:
        """What comes late is watched as long; but not for ever, if something always changes."""
        if facts.ready_s is None:
            return INFINITY
        for_s = self._script.run_time_s()
        most_s = min(facts.ready_s + 2 * for_s, self._script.ready_limit_s() + for_s)
        return min(max(facts.ready_s, changed_s(facts) + for_s), most_s)

    def _accompany(self, facts: Facts) -> None:
        """Subscribe to what has a publisher, as the rates of the file will."""
        probe, seen = self._system.probe, facts.last_graph()
        if probe is None or seen is None:
            return
        for topic in {e.topic for e in seen.snapshot.endpoints if e.is_publisher}:
            types = {e.type for e in seen.snapshot.on(topic)}
            is_wanted = not is_common(topic) and len(types) == 1 and not is_heavy([*types])
            if is_wanted and topic not in self._subscribed:
                self._subscribed.add(topic)
                probe.send("subscribe", sub=topic, topic=topic, type=None, qos=None)

    def _check_probe(self) -> None:
        super()._check_probe()
        seen = self._system.facts().last_graph()
        if self._system.probe is None or seen is None or self._probe_fault is not None:
            return
        for service, types in seen.services.items():
            if GET_STATE in types:
                self._ask_state(service)

    def _ask_state(self, service: str) -> None:
        try:
            answer = self._system.call(service, GET_STATE, None, ANSWER_S)
        except LauncherError:
            return  # it is busy, and its state is not recorded
        self.states[service] = str(answer["current_state"]["label"])


def begin_s(facts: Facts, for_s: float) -> float:
    """When the time of a run began in which nothing changed."""
    quiet_s = changed_s(facts)
    is_quiet = facts.stop_s - quiet_s >= 0.9 * for_s
    return quiet_s if is_quiet else max(facts.steps[START], facts.stop_s - for_s)
