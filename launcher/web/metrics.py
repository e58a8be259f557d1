"""What the feeds know, as metrics for Prometheus (docs/guides/metrics.md)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from prometheus_client import CollectorRegistry
from prometheus_client.exposition import choose_encoder
from prometheus_client.metrics_core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

if TYPE_CHECKING:
    from launcher.web.graph_feed import GraphFeed
    from launcher.web.run_feed import RunFeed

WATCH_S = 60.0  # the rates of topics are measured so long after a scrape
LAUNCHER = "launch"  # the name of the launcher among the processes
STATES = ("STOPPED", "STARTING", "RUNNING", "BACKOFF", "STOPPING", "EXITED", "FATAL")
NODE_STATES = ("running", "ghost", "gone")
EXPECTATION_STATES = ("open", "passed", "failed")
FAULT_STATES = ("suspected", "active", "healed")
_TOTAL = "_total"

Document = Mapping[str, Any]
Value = tuple[Sequence[object], float | None]  # labels, and null where it is not known


@dataclass(frozen=True, slots=True)
class MetricDefinition:
    """A metric; a counter if its name says so."""

    name: str
    labels: tuple[str, ...]
    help: str

    def family(self) -> CounterMetricFamily | GaugeMetricFamily:
        if self.name.endswith(_TOTAL):
            name = self.name.removesuffix(_TOTAL)
            return CounterMetricFamily(name, self.help, labels=self.labels)
        return GaugeMetricFamily(self.name, self.help, labels=self.labels)


_PROCESS, _TOPIC = ("process",), ("topic",)
DEFINITIONS = (
    MetricDefinition(
        "launcher_run_info",
        ("run_id", "target", "domain_id", "version"),
        "1, with what the run is in the labels",
    ),
    MetricDefinition("launcher_run_start_time_seconds", (), "Start of the launcher, since 1970"),
    MetricDefinition("launcher_process_up", _PROCESS, "1 if the process runs, else 0"),
    MetricDefinition(
        "launcher_process_state", ("process", "state"), "1 for the state that it is in"
    ),
    MetricDefinition("launcher_process_restarts_total", _PROCESS, "Restarts by its restart policy"),
    MetricDefinition("launcher_process_uptime_seconds", _PROCESS, "Time since its last start"),
    MetricDefinition(
        "launcher_process_cpu_ratio", _PROCESS, "CPU in the last second, 1 for one core"
    ),
    MetricDefinition("launcher_process_memory_bytes", _PROCESS, "Memory that is not shared (USS)"),
    MetricDefinition("launcher_process_resident_memory_bytes", _PROCESS, "Resident memory (RSS)"),
    MetricDefinition("launcher_process_threads", _PROCESS, "Threads"),
    MetricDefinition("launcher_process_open_fds", _PROCESS, "Open file descriptors"),
    MetricDefinition(
        "launcher_process_lines_total", _PROCESS, "Lines of its output, skipped ones too"
    ),
    MetricDefinition(
        "launcher_log_lines_total", ("process", "level"), "Lines that were read, by level"
    ),
    MetricDefinition("launcher_lines_skipped_total", (), "Lines that came too fast to be read"),
    MetricDefinition("launcher_nodes", ("state",), "Nodes of the ROS graph"),
    MetricDefinition("launcher_topic_publishers", _TOPIC, "Publishers in the ROS graph"),
    MetricDefinition("launcher_topic_subscriptions", _TOPIC, "Subscriptions in the ROS graph"),
    MetricDefinition(
        "launcher_topic_mismatches", _TOPIC, "Endpoints that QoS keeps apart from others"
    ),
    MetricDefinition("launcher_topic_rate_hertz", _TOPIC, "Messages a second"),
    MetricDefinition("launcher_topic_bytes_per_second", _TOPIC, "Size of the messages of a second"),
    MetricDefinition("launcher_topic_age_seconds", _TOPIC, "Time since the last message"),
    MetricDefinition("launcher_topic_messages_total", _TOPIC, "Messages since it is measured"),
    MetricDefinition("launcher_expectations", ("state",), "Expectations of a smoke run"),
    MetricDefinition("launcher_faults", ("state",), "Faults of a watched run"),
    MetricDefinition(
        "launcher_fault_active", ("fault", "expectation"), "1 while the fault is active, else 0"
    ),
    MetricDefinition(
        "launcher_faults_confirmed_total", ("fault",), "How often the fault was confirmed"
    ),
)


class Metrics(Collector):
    """The metrics of one run, in a separate registry."""

    def __init__(self, run: RunFeed, graph: GraphFeed) -> None:
        self._run = run
        self._graph = graph
        self._registry = CollectorRegistry(auto_describe=False)
        self._registry.register(self)

    def text(self, accept: str) -> tuple[bytes, str]:
        """(content, media type) of a scrape whose header Accept this is."""
        encode, kind = choose_encoder(accept)
        return encode(self._registry), kind

    def collect(self) -> Iterator[Metric]:
        values: dict[str, list[Value]] = {}
        for part in (
            _of_run(self._run),
            _of_processes(self._run.rows),
            _of_log(self._run.log),
            _of_graph(self._graph.graph),
            _of_traffic(self._graph.traffic),
            _of_expectations(self._run.expectations),
            _of_faults(self._run.faults.known),
        ):
            for name, labels, value in part:
                values.setdefault(name, []).append((labels, value))
        for definition in DEFINITIONS:
            family = definition.family()
            for labels, value in values.get(definition.name, ()):
                if value is not None:
                    family.add_metric([_text(label) for label in labels], value)
            yield family


Part = Iterator[tuple[str, Sequence[object], float | None]]


def _text(label: object) -> str:
    """A label: names may have bytes that are no characters."""
    return "" if label is None else str(label).encode(errors="replace").decode()


def _of_run(feed: RunFeed) -> Part:
    run = feed.run
    labels = (run.get("id"), run.get("target"), run.get("domain_id"), feed.launcher)
    yield "launcher_run_info", labels, 1
    yield "launcher_run_start_time_seconds", (), run.get("started_wall_s")


def _of_processes(rows: Sequence[Document]) -> Part:
    for row in rows:
        name = (row["name"],)
        cpu, is_up = row.get("cpu_percent"), row.get("pid") is not None
        yield "launcher_process_up", name, int(is_up)
        for state in STATES:
            yield "launcher_process_state", (row["name"], state), int(row["state"] == state)
        yield "launcher_process_restarts_total", name, row.get("restarts")
        yield "launcher_process_uptime_seconds", name, row.get("uptime_s")
        yield "launcher_process_cpu_ratio", name, None if cpu is None else cpu / 100
        yield "launcher_process_memory_bytes", name, row.get("uss_bytes")
        yield "launcher_process_resident_memory_bytes", name, row.get("rss_bytes")
        yield "launcher_process_threads", name, row.get("threads")
        yield "launcher_process_open_fds", name, row.get("fds")


def _of_log(log: Any) -> Part:
    for process, count in log.lines.items():
        yield "launcher_process_lines_total", (process or LAUNCHER,), count
    for (process, level), count in log.counts.items():
        yield "launcher_log_lines_total", (process or LAUNCHER, level), count
    yield "launcher_lines_skipped_total", (), log.skipped


def _of_graph(graph: Document | None) -> Part:
    if graph is None:
        return
    states = Counter(node["state"] for node in graph["nodes"] if not node.get("hidden"))
    for state in NODE_STATES:
        yield "launcher_nodes", (state,), states[state]
    mismatches = Counter(one["topic"] for one in graph.get("mismatches", ()))
    for topic in graph["topics"]:
        name = (topic["name"],)
        yield "launcher_topic_publishers", name, topic.get("publishers")
        yield "launcher_topic_subscriptions", name, topic.get("subscriptions")
        yield "launcher_topic_mismatches", name, mismatches[topic["name"]]


def _of_traffic(traffic: Mapping[str, Document]) -> Part:
    for topic, one in traffic.items():
        yield "launcher_topic_rate_hertz", (topic,), one.get("rate_hz")
        yield "launcher_topic_bytes_per_second", (topic,), one.get("bytes_per_s")
        yield "launcher_topic_age_seconds", (topic,), one.get("age_s")
        yield "launcher_topic_messages_total", (topic,), one.get("count")


def _of_expectations(message: Document | None) -> Part:
    if message is None:
        return
    states = Counter(one.get("state") for one in message["items"])
    for state in EXPECTATION_STATES:
        yield "launcher_expectations", (state,), states[state]


def _of_faults(known: Mapping[str, Document] | None) -> Part:
    if known is None:
        return
    states = Counter(one["state"] for one in known.values())
    for state in FAULT_STATES:
        yield "launcher_faults", (state,), states[state]
    for name, one in known.items():
        labels = (name, one["expectation"])
        yield "launcher_fault_active", labels, int(one["state"] == "active")
        yield "launcher_faults_confirmed_total", (name,), one["count"]
