"""Timeline: which steps are due, given what was seen; and what chaos does when. Pure decisions."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from launcher.smoke.facts import READY, Facts
from launcher.smoke.steps import Chaos, Command, Step


class Timeline:
    """Hands out each step once, when its time has come.

    A step after another one waits until that has been done.
    """

    def __init__(self, steps: Sequence[Step]) -> None:
        self._waiting = list(steps)
        self._done = {step.name: step.done for step in steps}

    def due(self, facts: Facts) -> list[Step]:
        """The steps whose time has come, in their order."""
        found = [step for step in self._waiting if self._is_due(step, facts)]
        self._waiting = [step for step in self._waiting if step not in found]
        return found

    def _is_due(self, step: Step, facts: Facts) -> bool:
        begin_s = facts.steps.get(self._done.get(step.after, step.after))
        if begin_s is not None and step.after_log is not None:
            begin_s = _line_s(step, facts, begin_s)
        return begin_s is not None and facts.now_s >= begin_s + step.delay_s

    @property
    def waiting(self) -> tuple[Step, ...]:
        """Those that have not happened."""
        return tuple(self._waiting)


def _line_s(step: Step, facts: Facts, begin_s: float) -> float | None:
    assert step.after_log is not None
    for line in facts.lines:
        if line.at_s < begin_s or line.process is None or not step.after_log.search(line.plain):
            continue
        if step.process is None or facts.is_named(line.process, step.process):
            return line.at_s
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke:
    """One thing that chaos does; `process` None: there was nobody to do it to."""

    number: int
    process: str | None
    command: Command


class Strokes:
    """What chaos does, one stroke every so often from the moment when the system is ready.

    The same seed chooses the same processes out of the same ones: each stroke takes one random
    number, whatever became of the strokes before.
    """

    def __init__(self, chaos: Chaos) -> None:
        self._chaos = chaos
        self._random = random.Random(chaos.seed)
        self._done = 0

    def due(self, facts: Facts) -> Iterator[Stroke]:
        """The strokes whose time has come."""
        ready_s = facts.steps.get(READY)
        if ready_s is None:
            return
        while facts.now_s >= ready_s + (self._done + 1) * self._chaos.every_s:
            self._done += 1
            yield self._stroke(facts)

    def _stroke(self, facts: Facts) -> Stroke:
        number = self._random.random()
        names = sorted(facts.named(self._chaos.pattern))
        name = names[int(number * len(names))] if names else None
        words = {"name": name, "signal": "SIGKILL", "time_s": self._chaos.time_s}
        text = f"{self._chaos.verb} {name}"
        command = Command(verb=self._chaos.verb, text=text, words=words)
        return Stroke(number=self._done, process=name, command=command)
