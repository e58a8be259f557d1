"""Recorder: collects what the threads of a System see, and hands it out as Facts."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from launcher.smoke.observe.facts import (
    START,
    Answer,
    Ending,
    Facts,
    GraphSeen,
    LogLine,
    Message,
    ProcessEvent,
    Sample,
)

T = TypeVar("T")
SHORTEST_S = 0.01


class Recorder:
    """One clock and one lock; every `add` wakes those who wait."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._start_s = time.monotonic()
        self._wall_s = time.time()
        self._lines: list[LogLine] = []
        self._messages: list[Message] = []
        self._graphs: list[GraphSeen] = []
        self._events: list[ProcessEvent] = []
        self._samples: list[Sample] = []
        self._answers: dict[str, list[Answer]] = {}
        self._services: tuple[str, ...] = ()
        self._steps: dict[str, float] = {START: 0.0}
        self._nodes: dict[str, tuple[str, ...]] = {}
        self._asked: set[str] = set()
        self._troubles: list[str] = []
        self._lost_messages = 0
        self._in_order: tuple[LogLine, ...] | None = ()
        self._ending: Ending | None = None

    # ---- the clock

    def begin(self) -> None:
        """The launcher is started now."""
        self._start_s, self._wall_s = time.monotonic(), time.time()

    @property
    def now_s(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._start_s

    def of_monotonic(self, monotonic_s: float) -> float:
        """A time of this machine's monotonic clock as time of the run."""
        return monotonic_s - self._start_s

    def of_wall(self, wall_s: float) -> float:
        """A time since 1970 as time of the run."""
        return wall_s - self._wall_s

    # ---- adding

    def add_line(self, line: LogLine) -> None:
        """A line of output."""
        with self._changed:
            self._lines.append(line)
            self._in_order = None
            self._changed.notify_all()

    def add_message(self, message: Message) -> None:
        """A message of a topic."""
        self._add(self._messages.append, message)

    def add_graph(self, graph: GraphSeen) -> None:
        """A change of the graph."""
        self._add(self._graphs.append, graph)

    def add_event(self, event: ProcessEvent) -> None:
        """An entry of the journal."""
        self._add(self._events.append, event)

    def add_samples(self, samples: Iterable[Sample], nodes: Mapping[str, tuple[str, ...]]) -> None:
        """What the processes use, and which nodes they are."""
        with self._changed:
            self._samples.extend(samples)
            self._nodes.update(nodes)
            self._changed.notify_all()

    def add_answer(self, key: str, answer: Answer) -> None:
        """An answer to a question."""
        self._add(self._answers.setdefault(key, []).append, answer)

    def set_services(self, names: Iterable[str]) -> None:
        """The services that the graph has now."""
        with self._changed:
            self._services = tuple(names)

    def add_trouble(self, text: str) -> None:
        """Something that kept us from seeing."""
        self._add(self._troubles.append, text)

    def lose(self, messages: int) -> None:
        """So many messages could not be taken down."""
        with self._changed:
            self._lost_messages += messages

    def step(self, name: str) -> None:
        """A step happens now; only the first time counts."""
        self._add(lambda at_s: self._steps.setdefault(name, at_s), self.now_s)

    def ask(self, process: str) -> None:
        """A step ends this process: its death is no surprise."""
        self._add(self._asked.add, process)

    def replace_events(self, events: Iterable[ProcessEvent]) -> None:
        """The journal as it was written, in place of what was heard of it."""
        with self._changed:
            self._events[:] = list(events)
            self._changed.notify_all()

    def replace_lines(self, lines: Iterable[LogLine]) -> None:
        """The log as it was written, in place of what was heard of it."""
        with self._changed:
            self._lines[:] = list(lines)
            self._in_order = None
            self._changed.notify_all()

    def end(self, ending: Ending) -> None:
        """Nothing more will come."""
        with self._changed:
            self._ending = ending
            self._changed.notify_all()

    def _add(self, into: Callable[[Any], object], value: object) -> None:
        with self._changed:
            into(value)
            self._changed.notify_all()

    # ---- asking

    def facts(self) -> Facts:
        """Everything up to now; lines in order of time."""
        with self._changed:
            if self._in_order is None:
                self._in_order = tuple(sorted(self._lines, key=lambda line: line.at_s))
            return Facts(
                now_s=self.now_s,
                lines=self._in_order,
                messages=tuple(self._messages),
                graphs=tuple(self._graphs),
                events=tuple(self._events),
                samples=tuple(self._samples),
                answers={key: tuple(found) for key, found in self._answers.items()},
                services=self._services,
                steps=dict(self._steps),
                node_names=dict(self._nodes),
                asked=frozenset(self._asked),
                troubles=tuple(self._troubles),
                lost_messages=self._lost_messages,
                ending=self._ending,
            )

    def wait_for(
        self, fact: Callable[[Facts], T | None], within_s: float, *, look_s: float = 0.5
    ) -> T | None:
        """The first true answer of `fact`; what it says at the end of the time otherwise."""
        deadline_s = time.monotonic() + within_s
        while True:
            found = fact(self.facts())
            left_s = deadline_s - time.monotonic()
            if found or left_s <= 0:
                return found
            with self._changed:
                self._changed.wait(min(left_s, look_s))
            time.sleep(SHORTEST_S)  # many things come at once, and looking has its price
