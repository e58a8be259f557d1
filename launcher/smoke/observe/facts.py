"""Observations of a run from outside: frozen values, the only input of the judges.

All `at_s` are seconds since the start of the launcher.
"""

from __future__ import annotations

import fnmatch
import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from launcher.base.model.run_event import RunEvent, fields_of
from launcher.base.model.run_events import Ended, NotStarted, Ready, Started, Waiting, Withdrawn
from launcher.base.model.run_options import program_of
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph
from launcher.smoke.expect.expectation import LAUNCHER, READY, START, STOP

if TYPE_CHECKING:
    from launcher.bag.comparing.topic_traits import Traits

E = TypeVar("E", bound=RunEvent)

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
        """The text without colours."""
        return _COLOUR.sub("", self.text) if "\x1b" in self.text else self.text

    @property
    def level(self) -> str | None:
        """DEBUG, INFO, WARN, ERROR or FATAL, as rclpy and the launcher write it."""
        match = _LEVEL.search(self.plain[:120])
        return match[1] if match else None


@dataclass(frozen=True, slots=True, kw_only=True)
class ObservedMessage:
    """`content` is plain JSON; `sent_s`: when it was published, if known; `watch`: subscription.

    `stamp_s`: the time with which the message begins, if it does.
    """

    at_s: float
    topic: str
    content: object
    sent_s: float | None = None
    stamp_s: float | None = None
    watch: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraphSeen:
    """The ROS graph from one moment on; topics and services with their types."""

    at_s: float
    snapshot: TopicGraph
    topics: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    services: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessEvent(Generic[E]):
    """An entry of events.jsonl (docs/reference/events.md)."""

    at_s: float
    event: E
    process: str | None = None
    host: str | None = None

    @property
    def kind(self) -> str:
        """`started`, `ended`, `signal`, `stopping`, ..."""
        return self.event.event

    @property
    def details(self) -> Mapping[str, Any]:
        """The fields of the event, and `host` where the process is on another one."""
        host = {} if self.host is None else {"host": self.host}
        return {**host, **fields_of(self.event)}


@dataclass(frozen=True, slots=True)
class UsageSample:
    """Resource usage of a process; None where it is not known."""

    at_s: float
    process: str
    cpu_percent: float | None = None
    memory_bytes: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class QueryAnswer:
    """The value of a parameter or the response of a service, or an error with its hint."""

    at_s: float
    value: Any = None
    error: str | None = None
    hint: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """The end of a run. `returncode` is the launcher's, None if it had to be killed.

    `left_processes` outlived the launcher; `left_memory` are names in /dev/shm.
    """

    asked_s: float | None
    down_s: float
    returncode: int | None
    left_processes: tuple[str, ...] = ()
    left_memory: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Everything observed up to `now_s`; `ending` is set when the run is over.

    `steps`: time of each step, with `start` and `ready`; `node_names`: nodes of each process, from
    the launch file; `ended_by_steps`: processes that a step has ended;
    `lost_messages`: received too fast; `recorded`: topics of the bag that was recorded.
    """

    now_s: float = 0.0
    lines: tuple[LogLine, ...] = ()
    messages: tuple[ObservedMessage, ...] = ()
    graphs: tuple[GraphSeen, ...] = ()
    events: tuple[ProcessEvent[RunEvent], ...] = ()
    samples: tuple[UsageSample, ...] = ()
    answers: Mapping[str, tuple[QueryAnswer, ...]] = field(default_factory=dict)
    services: tuple[str, ...] = ()
    steps: Mapping[str, float] = field(default_factory=lambda: {START: 0.0})
    node_names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    ended_by_steps: frozenset[str] = frozenset()
    troubles: tuple[str, ...] = ()
    lost_messages: int = 0
    recorded: Mapping[str, Traits] | None = None
    ending: Ending | None = None

    @property
    def is_over(self) -> bool:
        return self.ending is not None

    @property
    def ready_s(self) -> float | None:
        return self.steps.get(READY)

    @property
    def stop_s(self) -> float:
        """When the system was stopped or ended by itself; now while it runs."""
        if STOP in self.steps:
            return self.steps[STOP]
        return self.now_s if self.ending is None else self.ending.down_s

    def processes(self) -> tuple[str, ...]:
        """All processes that were started or failed to start."""
        names = (e.process for e in self.events if isinstance(e.event, (Started, NotStarted)))
        return tuple(dict.fromkeys(name for name in names if name))

    def unready(self, pattern: str = "*") -> tuple[str, ...]:
        """The processes that wait for others, or are not ready, as the launcher says."""
        found: dict[str, None] = {}
        for event in self.events:
            match event.event:
                case Waiting() | Started(ready_when=(_, *_)):
                    found[str(event.process)] = None
                case Ready() | Started() | Withdrawn() | Ended() | NotStarted():
                    found.pop(str(event.process), None)
        return tuple(name for name in found if self.is_named(name, pattern))

    def named(self, pattern: str) -> tuple[str, ...]:
        """The processes that match a pattern, by name, label or node name."""
        return tuple(name for name in self.processes() if self.is_named(name, pattern))

    def is_named(self, process: str, pattern: str) -> bool:
        """Patterns are as `robot_2-4`, `robot_2`, `robot_*` or `/robot_2`."""
        return matches(pattern, process, self.node_names.get(process, ()))

    def is_from(self, line: LogLine, pattern: str | None) -> bool:
        """None matches all processes; the launcher's own lines only match `launch`."""
        if line.process is None:
            return pattern == LAUNCHER
        return pattern is None or self.is_named(line.process, pattern)

    def process_of(self, node: str) -> str | None:
        """The process of a node by its full name, if the launch file names it."""
        by_name = (p for p, nodes in self.node_names.items() if node in nodes)
        by_label = (p for p in self.processes() if label_of(p) == node.rpartition("/")[2])
        return next(by_name, None) or next(by_label, None)

    def of(self, kind: type[E], process: str | None = None) -> Iterator[ProcessEvent[E]]:
        """The events of a type, of one process or of all."""
        for event in self.events:
            if isinstance(event.event, kind) and process in (None, event.process):
                yield cast("ProcessEvent[E]", event)

    def was_running(self, process: str, at_s: float) -> bool:
        alive = False
        for event in self.events:
            if event.process == process and event.at_s <= at_s:
                alive = {Started: True, Ended: False}.get(type(event.event), alive)
        return alive

    def last_end(self, process: str) -> ProcessEvent[Ended] | None:
        return next(reversed([*self.of(Ended, process)]), None)

    def last_lines(self, process: str, count: int = 10) -> tuple[LogLine, ...]:
        """The last lines of a process, without empty ones."""
        found = [line for line in self.lines if line.process == process and line.plain.strip()]
        return tuple(found[-count:])

    def graph(self) -> TopicGraph:
        """The newest graph; after the stop, which empties it, the last one before."""
        seen = self.last_graph()
        return TopicGraph(nodes=(), endpoints=()) if seen is None else seen.snapshot

    def last_graph(self) -> GraphSeen | None:
        """`graph()` with its time; None if there was none."""
        before = [seen for seen in self.graphs if seen.at_s <= self.stop_s]
        return before[-1] if before else None

    def endpoints(self, topic: str) -> tuple[Endpoint, ...]:
        return self.graph().on(topic)

    def received(self, topic: str, watch: str | None = None) -> tuple[ObservedMessage, ...]:
        """The messages of a topic, received by one subscription of the probe or by any."""
        return tuple(m for m in self.messages if m.topic == topic and watch in (None, m.watch))


@functools.lru_cache(maxsize=4096)  # called for every line by every judge
def matches(pattern: str, process: str, nodes: tuple[str, ...]) -> bool:
    label = label_of(process)
    names = {process, label, *program_of(label), *nodes, *(n.rpartition("/")[2] for n in nodes)}
    return any(fnmatch.fnmatchcase(name, pattern) for name in names)


def label_of(process: str) -> str:
    """`robot_2` of `robot_2-4`."""
    return _NUMBER.sub("", process)
