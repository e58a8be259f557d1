"""Timeline: which steps are due, given what was seen; and what chaos does when. Pure decisions."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.errors import LauncherError
from launcher.smoke.expect.steps import Chaos, Command, Step
from launcher.smoke.observe.facts import READY, Facts
from launcher.smoke.run.system import System


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
class ChaosAction:
    """One thing that chaos does; `process` None: there was nobody to do it to."""

    number: int
    process: str | None
    command: Command


class ChaosTimeline:
    """What chaos does, one stroke every so often from the moment when the system is ready.

    The same seed chooses the same processes out of the same ones: each stroke takes one random
    number, whatever became of the strokes before.
    """

    def __init__(self, chaos: Chaos) -> None:
        self._chaos = chaos
        self._random = random.Random(chaos.seed)
        self._done = 0

    def due(self, facts: Facts) -> Iterator[ChaosAction]:
        """The strokes whose time has come."""
        ready_s = facts.steps.get(READY)
        if ready_s is None:
            return
        while facts.now_s >= ready_s + (self._done + 1) * self._chaos.every_s:
            self._done += 1
            yield self._stroke(facts)

    def _stroke(self, facts: Facts) -> ChaosAction:
        number = self._random.random()
        names = sorted(facts.named(self._chaos.pattern))
        name = names[int(number * len(names))] if names else None
        words = {"name": name, "signal": "SIGKILL", "time_s": self._chaos.time_s}
        text = f"{self._chaos.verb} {name}"
        command = Command(verb=self._chaos.verb, text=text, words=words)
        return ChaosAction(number=self._done, process=name, command=command)


PAUSE_LOOK_S = 0.05


class CommandRunner:
    """`do` returns at once; `on_done(error)` is called in the command's thread."""

    def __init__(self, system: System, is_over: threading.Event) -> None:
        self._system = system
        self._is_over = is_over

    def do(
        self,
        command: Command,
        on_done: Callable[[str | None], None],
        on_over: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_over` is called at the end of a pause."""

        def work() -> None:
            try:
                self._carry_out(command)
            except LauncherError as error:
                on_done(error.message + (f" ({error.hint})" if error.hint else ""))
                return
            on_done(None)
            self._end_pause(command, on_over)

        threading.Thread(target=work, daemon=True, name=command.text).start()

    def _end_pause(self, command: Command, on_over: Callable[[], None]) -> None:
        time_s = command.words.get("time_s")
        if command.verb != "pause" or time_s is None:
            return
        end_s = time.monotonic() + time_s
        while time.monotonic() < end_s and not self._is_over.is_set():
            time.sleep(min(PAUSE_LOOK_S, max(0.0, end_s - time.monotonic())))
        try:
            self._system.resume(command.words["name"])
        except LauncherError:
            return  # it has ended meanwhile
        on_over()

    def _carry_out(self, command: Command) -> None:
        words: dict[str, Any] = command.words
        system = self._system
        verbs: dict[str, Callable[[], object]] = {
            "kill": lambda: system.kill(words["name"], words["signal"]),
            "stop": lambda: system.stop_process(words["name"]),
            "start": lambda: system.start_process(words["name"]),
            "restart": lambda: system.restart_process(words["name"]),
            "pause": lambda: system.pause(words["name"]),
            "resume": lambda: system.resume(words["name"]),
            "send": lambda: system.send(words["name"], words["text"]),
            "publish": lambda: system.publish(words["topic"], words["type"], words["value"]),
            "set": lambda: system.set_parameter(words["node"], words["parameter"], words["value"]),
            "call": lambda: system.call(words["service"], words["type"], words.get("value")),
        }
        verbs[command.verb]()
