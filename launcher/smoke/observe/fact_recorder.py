"""Collects observations from several threads, and returns them as Facts."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from launcher.smoke.expect.expectation import START
from launcher.smoke.observe.facts import (
    Ending,
    Facts,
    GraphSeen,
    LogLine,
    ObservedMessage,
    ProcessEvent,
    QueryAnswer,
    UsageSample,
)

if TYPE_CHECKING:
    from launcher.bag.comparing.topic_traits import Traits
    from launcher.base.model.run_event import RunEvent

T = TypeVar("T")
MIN_WAIT_S = 0.01


class FactRecorder:
    """One clock and one lock; every `add` wakes the callers of `wait_for`."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._start_s = time.monotonic()
        self._wall_s = time.time()
        self._observed: dict[type, list[Any]] = {
            kind: [] for kind in (LogLine, ObservedMessage, GraphSeen, ProcessEvent)
        }
        self._samples: list[UsageSample] = []
        self._answers: dict[str, list[QueryAnswer]] = {}
        self._services: tuple[str, ...] = ()
        self._steps: dict[str, float] = {START: 0.0}
        self._nodes: dict[str, tuple[str, ...]] = {}
        self._ended_by_steps: set[str] = set()
        self._troubles: list[str] = []
        self._lost_messages = 0
        self._sorted: tuple[LogLine, ...] = ()  # the lines; valid as long as it is as long
        self._recorded: Mapping[str, Traits] | None = None
        self._ending: Ending | None = None

    # ---- the clock

    def begin(self) -> None:
        """The launcher starts now."""
        self._start_s, self._wall_s = time.monotonic(), time.time()

    @property
    def now_s(self) -> float:
        return time.monotonic() - self._start_s

    def of_monotonic(self, monotonic_s: float) -> float:
        """Time of the run for a time of the monotonic clock."""
        return monotonic_s - self._start_s

    def of_wall(self, wall_s: float) -> float:
        """Time of the run for seconds since the epoch."""
        return wall_s - self._wall_s

    def wall_of(self, at_s: float) -> float:
        """Seconds since the epoch for a time of the run."""
        return self._wall_s + at_s

    # ---- adding

    def add(self, observed: LogLine | ObservedMessage | GraphSeen | ProcessEvent[RunEvent]) -> None:
        with self._change():
            self._observed[type(observed)].append(observed)

    def replace(
        self, kind: type[LogLine] | type[ProcessEvent[RunEvent]], observed: Iterable[object]
    ) -> None:
        """Replace everything of a kind, with what the files of the run have."""
        with self._change():
            self._observed[kind] = list(observed)
            self._sorted = ()

    def add_samples(
        self, samples: Iterable[UsageSample], nodes: Mapping[str, tuple[str, ...]]
    ) -> None:
        """`nodes` are the node names of each process."""
        with self._change():
            self._samples.extend(samples)
            self._nodes.update(nodes)

    def add_answer(self, key: str, answer: QueryAnswer) -> None:
        with self._change():
            self._answers.setdefault(key, []).append(answer)

    def set_services(self, names: Iterable[str]) -> None:
        with self._change():
            self._services = tuple(names)

    def add_trouble(self, text: str) -> None:
        """Report something that made observations incomplete."""
        with self._change():
            self._troubles.append(text)

    def add_lost_messages(self, count: int) -> None:
        with self._change():
            self._lost_messages += count

    def set_recorded(self, recorded: Mapping[str, Traits]) -> None:
        """What a bag has that was recorded."""
        with self._change():
            self._recorded = recorded

    def step(self, name: str) -> None:
        """A step happens now; only its first time counts."""
        at_s = self.now_s
        with self._change():
            self._steps.setdefault(name, at_s)

    def expect_exit(self, process: str) -> None:
        """A step ends this process: its exit is not unexpected."""
        with self._change():
            self._ended_by_steps.add(process)

    def end(self, ending: Ending) -> None:
        with self._change():
            self._ending = ending

    @contextlib.contextmanager
    def _change(self) -> Iterator[None]:
        with self._changed:
            yield
            self._changed.notify_all()

    # ---- reading

    def facts(self) -> Facts:
        """Everything up to now; lines are sorted by time."""
        with self._changed:
            lines = self._observed[LogLine]
            if len(lines) != len(self._sorted):
                self._sorted = tuple(sorted(lines, key=lambda line: line.at_s))
            return Facts(
                now_s=self.now_s,
                lines=self._sorted,
                messages=tuple(self._observed[ObservedMessage]),
                graphs=tuple(self._observed[GraphSeen]),
                events=tuple(self._observed[ProcessEvent]),
                samples=tuple(self._samples),
                answers={key: tuple(found) for key, found in self._answers.items()},
                services=self._services,
                steps=dict(self._steps),
                node_names=dict(self._nodes),
                ended_by_steps=frozenset(self._ended_by_steps),
                troubles=tuple(self._troubles),
                lost_messages=self._lost_messages,
                recorded=self._recorded,
                ending=self._ending,
            )

    def take(self) -> Facts:
        """What is new since the last call; `answers` are the last ones of each key."""
        with self._changed:
            found = self.facts()
            for observed in self._observed.values():
                observed.clear()
            self._samples.clear()
            self._sorted = ()
            self._answers = {key: answers[-1:] for key, answers in self._answers.items()}
            self._troubles.clear()
            return found

    def wait_for(
        self, fact: Callable[[Facts], T | None], within_s: float, *, poll_s: float = 0.5
    ) -> T | None:
        """The first true result of `fact`, or the last result on timeout."""
        deadline_s = time.monotonic() + within_s
        while True:
            found = fact(self.facts())
            left_s = deadline_s - time.monotonic()
            if found or left_s <= 0:
                return found
            with self._changed:
                self._changed.wait(min(left_s, poll_s))
            time.sleep(MIN_WAIT_S)  # events come in bursts, and `fact` has its cost
