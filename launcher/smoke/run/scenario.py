"""The scenario of a run: when its steps and chaos are due, and running their commands.

Every command has a separate thread: one that takes long (a process that does not stop) must not
delay the others.
"""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from launcher.base.errors import LauncherError
from launcher.output.filters import TooSlowError
from launcher.smoke.expect.expectation import READY, Decision, Expectation, Verdict
from launcher.smoke.expect.script import Script
from launcher.smoke.expect.steps import Chaos, Step, StepCommand
from launcher.smoke.inject.grammar import MACHINE
from launcher.smoke.judges.common import TOO_SLOW, search_limit
from launcher.smoke.observe.facts import Facts
from launcher.smoke.reports.result import Judged
from launcher.smoke.run.smoke_progress import SmokeProgress
from launcher.smoke.run.system import System

POLL_S = 0.05
_LASTING = ("pause", "inject")


class Scenario:
    """Runs the steps and the chaos of a script; `is_over` ends pauses."""

    def __init__(
        self, script: Script, system: System, progress: SmokeProgress, is_over: threading.Event
    ) -> None:
        self._system = system
        self._progress = progress
        self._is_over = is_over
        self._timeline = StepSchedule(script.steps, self._too_slow)
        self._chaos = None if script.chaos is None else ChaosTimeline(script.chaos)
        self._failures: list[tuple[Step, str]] = []

    def run_due(self, facts: Facts) -> None:
        """Start the commands that are due."""
        for step in self._timeline.due(facts):
            self._run_step(step)
        for action in () if self._chaos is None else self._chaos.due(facts):
            text = f"chaos {action.number}: {action.command.text}"
            if action.process is None or not facts.was_running(action.process, facts.now_s):
                self._say(f"{text}: not running")
                continue
            self._say(text)
            self._start(action.command, self._chaos_done, lambda: None)

    @property
    def waiting(self) -> tuple[Step, ...]:
        """The steps that have not been due."""
        return self._timeline.waiting

    def failures(self, *, with_waiting: bool) -> list[Judged]:
        """The steps that failed and, `with_waiting`, those that were never due."""
        found = [_failure(step, error) for step, error in self._failures]
        return found + [_missed(step) for step in self._timeline.waiting if with_waiting]

    def _too_slow(self, step: Step) -> None:
        self._failures.append((step, TOO_SLOW))
        self._say(f"step failed: {step.command.text}: {TOO_SLOW}")

    def _say(self, text: str) -> None:
        self._progress.log(self._system.recorder.now_s, text)

    def _chaos_done(self, error: str | None) -> None:
        if error is not None:
            self._say(f"chaos: {error}")

    def _run_step(self, step: Step) -> None:
        recorder, text = self._system.recorder, step.command.text

        def done(error: str | None) -> None:
            if error is None:
                recorder.step(step.done)
                self._say(f"step: {text}")
            elif not self._is_over.is_set():
                self._failures.append((step, error))
                self._say(f"step failed: {text}: {error}")

        def over() -> None:
            recorder.step(step.over)
            self._say(f"step: {text}: over")

        recorder.step(step.name)  # its effects may be observed before it is done
        self._start(step.command, done, over)

    def _start(
        self,
        command: StepCommand,
        on_done: Callable[[str | None], None],
        on_over: Callable[[], None],
    ) -> None:
        """`on_done` gets the error, if any; `on_over` is called at the end of its time."""

        def work() -> None:
            try:
                self._execute(command)
            except LauncherError as error:
                on_done(error.message + (f" ({error.hint})" if error.hint else ""))
                return
            on_done(None)
            if command.verb in _LASTING and command.words.get("time_s") is not None:
                self._wait(command.words["time_s"])
                if self._is_undone(command):
                    on_over()

        threading.Thread(target=work, daemon=True, name=command.text).start()

    def _wait(self, time_s: float) -> None:
        end_s = time.monotonic() + time_s
        while time.monotonic() < end_s and not self._is_over.is_set():
            time.sleep(min(POLL_S, max(0.0, end_s - time.monotonic())))

    def _is_undone(self, command: StepCommand) -> bool:
        """Whether a pause or an injection is over: it ends now, unless the process has exited."""
        name = command.words.get("name", MACHINE)
        try:
            if command.verb == "pause":
                self._system.control("resume", name)
                return True
            while self._system.has_injection(name, command.words["injection"]):
                if self._is_over.is_set():
                    return False
                time.sleep(POLL_S)
        except LauncherError:
            return False
        return True

    def _execute(self, command: StepCommand) -> None:
        system, words = self._system, command.words
        match command.verb:
            case "kill":
                system.kill(words["name"], words["signal"])
            case "send":
                system.send(words["name"], words["text"])
            case "publish":
                system.publish(words["topic"], words["type"], words["value"])
            case "set":
                system.set_parameter(words["node"], words["parameter"], words["value"])
            case "call":
                system.call(words["service"], words["type"], words.get("value"))
            case "inject":
                system.inject(words.get("name", MACHINE), words["injection"])
            case verb:
                system.control(verb, words["name"])


def _failure(step: Step, seen: str) -> Judged:
    expected = f"step '{step.command.text}' is done"
    return Judged(
        expectation=Expectation(
            kind="step", subject=step.name, name=f"step {step.name}", origin=step.origin
        ),
        verdict=Verdict(outcome=Decision.VIOLATED, expected=expected, seen=seen),
    )


def _missed(step: Step) -> Judged:
    if step.after_log is not None:
        return _failure(step, f"no line with '{step.after_log.pattern}' came")
    return _failure(step, "the run was over before")


class StepSchedule:
    """Hands out each step once, when it is due; `after` a step: once that is done.

    A step with an `after_log` that takes too long is dropped, and `on_slow` is called.
    """

    def __init__(
        self, steps: Sequence[Step], on_slow: Callable[[Step], None] = lambda step: None
    ) -> None:
        self._waiting = list(steps)
        self._on_slow = on_slow
        self._done = {step.name: step.done for step in steps}

    def due(self, facts: Facts) -> list[Step]:
        found: list[Step] = []
        waiting: list[Step] = []
        for step in self._waiting:
            try:
                with search_limit():
                    is_due = self._is_due(step, facts)
            except TooSlowError:
                self._on_slow(step)
            else:
                (found if is_due else waiting).append(step)
        self._waiting = waiting
        return found

    def _is_due(self, step: Step, facts: Facts) -> bool:
        begin_s = facts.steps.get(self._done.get(step.after, step.after))
        if begin_s is not None and step.after_log is not None:
            begin_s = _line_s(step, facts, begin_s)
        return begin_s is not None and facts.now_s >= begin_s + step.delay_s

    @property
    def waiting(self) -> tuple[Step, ...]:
        return tuple(self._waiting)


def _line_s(step: Step, facts: Facts, begin_s: float) -> float | None:
    """When the line that a step waits for was printed."""
    assert step.after_log is not None
    for line in facts.lines:
        is_after = line.at_s >= begin_s and line.process is not None
        if is_after and step.after_log.search(line.plain) and facts.is_from(line, step.process):
            return line.at_s
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChaosAction:
    """`process` None: no process matched."""

    number: int
    process: str | None
    command: StepCommand


class ChaosTimeline:
    """The actions of chaos at equal intervals, from when the system is ready.

    The same seed chooses the same processes: each action takes one random number, whatever became
    of the actions before.
    """

    def __init__(self, chaos: Chaos) -> None:
        self._chaos = chaos
        self._random = random.Random(chaos.seed)
        self._done = 0

    def due(self, facts: Facts) -> Iterator[ChaosAction]:
        ready_s = facts.steps.get(READY)
        if ready_s is None:
            return
        while facts.now_s >= ready_s + (self._done + 1) * self._chaos.every_s:
            self._done += 1
            yield self._action(facts)

    def _action(self, facts: Facts) -> ChaosAction:
        number = self._random.random()
        names = sorted(facts.named(self._chaos.pattern))
        name = names[int(number * len(names))] if names else None
        words = {"name": name, "signal": "SIGKILL", "time_s": self._chaos.time_s}
        text = f"{self._chaos.verb} {name}"
        command = StepCommand(verb=self._chaos.verb, text=text, words=words)
        return ChaosAction(number=self._done, process=name, command=command)
