"""Facts: what was seen of a run from outside, as frozen values on one clock.

`at_s` is seconds since the launcher was started. Expectations are judged over these values alone.
"""

from __future__ import annotations

import fnmatch
import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.ros.snapshot.graph import Endpoint, TopicGraph

START, READY, STOP = "start", "ready", "stop"
_LEVEL = re.compile(r"(?:^|\[)(DEBUG|INFO|WARN|ERROR|FATAL)(?:ING)?\]")
_COLOUR = re.compile(r"\x1b\[[0-9;:]*m")
_NUMBER = re.compile(r"-\d+$")


@dataclass(frozen=True, slots=True, kw_only=True)
class LogLine:
    """One line of output; `process` is None for the launcher's own."""

    at_s: float
    process: str | None
    text: str
    stream: str | None = None

    @property
    def plain(self) -> str:
        """Without colours."""
        return _COLOUR.sub("", self.text) if "\x1b" in self.text else self.text

    @property
    def level(self) -> str | None:
        """DEBUG, INFO, WARN, ERROR or FATAL, as rclpy and the launcher write it; None without."""
        match = _LEVEL.search(self.plain[:120])
        return match[1] if match else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """A message as plain JSON; `sent_s` is wall time, None if unknown."""

    at_s: float
    topic: str
    content: Any
    type: str = ""
    publisher: str | None = None
    sent_s: float | None = None
    watch: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraphSeen:
    """The ROS graph from one moment on."""

    at_s: float
    snapshot: TopicGraph
    topics: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessEvent:
    """An entry of the journal; `kind` is `started`, `ended`, `signal`, `stopping` and so on."""

    at_s: float
    kind: str
    process: str | None = None
    details: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """What a process used at one moment; None where it was not known."""

    at_s: float
    process: str
    cpu_percent: float | None = None
    memory_bytes: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """The answer to a question that an expectation asked; `error` is a sentence if there is none.

    `hint` belongs to the error. `value` is the parameter's value or the service's response.
    """

    at_s: float
    value: Any = None
    error: str | None = None
    hint: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How the run came down. `returncode` is the launcher's, None if it had to be killed.

    `left_processes` were still there afterwards, `left_memory` are names in /dev/shm.
    """

    asked_s: float | None
    down_s: float
    returncode: int | None
    left_processes: tuple[str, ...] = ()
    left_memory: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Everything that was seen up to `now_s`; `ending` is there when the run is over.

    `steps` are the times at which named steps happened, `start` and `ready` among them;
    `node_names` are the nodes of each process as the launch file names them; `asked` are the
    processes that a step of the scenario ended or stopped; `lost_messages` came too fast.
    """

    now_s: float = 0.0
    lines: tuple[LogLine, ...] = ()
    messages: tuple[Message, ...] = ()
    graphs: tuple[GraphSeen, ...] = ()
    events: tuple[ProcessEvent, ...] = ()
    samples: tuple[Sample, ...] = ()
    answers: Mapping[str, tuple[Answer, ...]] = field(default_factory=dict)
    services: tuple[str, ...] = ()
    steps: Mapping[str, float] = field(default_factory=lambda: {START: 0.0})
    node_names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    asked: frozenset[str] = frozenset()
    troubles: tuple[str, ...] = ()
    lost_messages: int = 0
    ending: Ending | None = None

    @property
    def is_over(self) -> bool:
        """Whether nothing more will be seen."""
        return self.ending is not None

    @property
    def ready_s(self) -> float | None:
        """When the system was up."""
        return self.steps.get(READY)

    @property
    def stop_s(self) -> float:
        """When the system was asked to stop or ended by itself; now if it still runs."""
        if STOP in self.steps:
            return self.steps[STOP]
        return self.now_s if self.ending is None else self.ending.down_s

    def processes(self) -> tuple[str, ...]:
        """The names of all processes that were started, or could not be."""
        names = (e.process for e in self.events if e.kind in ("started", "not started"))
        return tuple(dict.fromkeys(name for name in names if name))

    def named(self, pattern: str) -> tuple[str, ...]:
        """The processes that a pattern means: by name, by label, or by node name."""
        return tuple(name for name in self.processes() if self.is_named(name, pattern))

    def is_named(self, process: str, pattern: str) -> bool:
        """Whether a pattern means this process: `robot_2-4`, `robot_2`, `robot_*`, `/robot_2`."""
        return means(pattern, process, self.node_names.get(process, ()))

    def process_of(self, node: str) -> str | None:
        """The process that a full node name belongs to, as far as the launch file tells."""
        by_name = (p for p, nodes in self.node_names.items() if node in nodes)
        by_label = (p for p in self.processes() if _NUMBER.sub("", p) == node.rpartition("/")[2])
        return next(by_name, None) or next(by_label, None)

    def of(self, kind: str, process: str | None = None) -> Iterator[ProcessEvent]:
        """The events of a kind, of one process or of all."""
        for event in self.events:
            if event.kind == kind and process in (None, event.process):
                yield event

    def lives(self, process: str, at_s: float) -> bool:
        """Whether a process ran at this time."""
        alive = False
        for event in self.events:
            if event.process == process and event.at_s <= at_s:
                alive = {"started": True, "ended": False}.get(event.kind, alive)
        return alive

    def last_lines(self, process: str, count: int = 10) -> tuple[LogLine, ...]:
        """The last that a process printed, without empty lines."""
        found = [line for line in self.lines if line.process == process and line.plain.strip()]
        return tuple(found[-count:])

    def graph(self) -> TopicGraph:
        """The newest graph, or the last one before the stop, which empties it."""
        seen = self.last_graph()
        return TopicGraph(nodes=(), endpoints=()) if seen is None else seen.snapshot

    def last_graph(self) -> GraphSeen | None:
        """The same with its time; None if none was seen."""
        before = [seen for seen in self.graphs if seen.at_s <= self.stop_s]
        return before[-1] if before else None

    def endpoints(self, topic: str) -> tuple[Endpoint, ...]:
        """The endpoints that a topic has now."""
        return self.graph().on(topic)

    def heard(self, topic: str, watch: str | None = None) -> tuple[Message, ...]:
        """The messages of a topic, through one of our subscriptions or through any."""
        return tuple(m for m in self.messages if m.topic == topic and watch in (None, m.watch))


@functools.lru_cache(maxsize=4096)
def means(pattern: str, process: str, nodes: tuple[str, ...]) -> bool:
    """Whether a pattern means a process with these nodes; asked for every line, by everybody."""
    names = {process, _NUMBER.sub("", process), *nodes, *(n.rpartition("/")[2] for n in nodes)}
    return any(fnmatch.fnmatchcase(name, pattern) for name in names)
