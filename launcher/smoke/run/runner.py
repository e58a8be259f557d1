"""Runner: one smoke run, from the lease on a domain to the last verdict. Always bounded in time."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from launcher.errors import ExitCode, LauncherError
from launcher.smoke.expect.expectation import Expectation, Outcome, Verdict
from launcher.smoke.expect.expectation_kinds import judge
from launcher.smoke.expect.quantities import INFINITY, seconds_text
from launcher.smoke.expect.script import OF_EVERY_RUN, SHORTEST_S, Script
from launcher.smoke.expect.steps import Step
from launcher.smoke.judges.run import forced_stop
from launcher.smoke.observe.facts import READY, Facts
from launcher.smoke.reports.picture import Picture
from launcher.smoke.reports.result import Judged, Result
from launcher.smoke.run.interruption import code_of
from launcher.smoke.run.probe_requests import AnswerPoller, subscribed
from launcher.smoke.run.progress import Progress
from launcher.smoke.run.scenario import ChaosTimeline, CommandRunner, Timeline
from launcher.smoke.run.system import STOP_S, System

LOOK_S = 0.1
JUDGE_S = 0.5  # judging all of a long run's messages has its price
JUDGE_SHARE = 4  # of the time at least so many times what the last look took goes by without one
PICTURE_S = 1.0  # before the end, the graph is looked at if nobody does
STOP_ROOM_S = 15.0  # the launcher ends by itself this long after we should have ended it
EMPTY_STOP_S = 5.0  # a launcher that has started nothing has nothing to wait for
WORDS = 200  # lines of a launcher that has started nothing: they say why
# Without a time of their own, these are decided by the end, whenever that is.
UNTIL_THE_END = (
    "process",
    "no_deaths",
    "no_errors",
    "no_tracebacks",
    "cpu",
    "memory",
    "clean_shutdown",
    "shared_memory",
)


class Runner:
    """Runs a script once. `words` are the target and what else the launcher is to be told.

    `keeps_graph` is whether a picture of the ROS graph is wanted even if nothing of it is expected.
    """

    def __init__(
        self,
        script: Script,
        words: Sequence[str],
        folder: Path,
        narrator: Progress,
        *,
        keeps_graph: bool = False,
    ) -> None:
        self._keeps_graph = keeps_graph
        self._script = script.completed()
        self._words = tuple(words)
        self._folder = folder
        self._narrator = narrator
        self._is_over = threading.Event()
        self._timeline = Timeline(script.steps)
        self._strokes = None if script.chaos is None else ChaosTimeline(script.chaos)
        self._failed_steps: list[tuple[Step, str]] = []
        self._decided: dict[str, Verdict] = {}
        self._gave_up = False
        self._blind: str | None = None
        self._interrupted: ExitCode | None = None
        self._next_look_s = 0.0

    def run(self) -> Result:
        """Start, watch, stop, judge. Ctrl-C stops the system, too."""
        run_time_s = self._script.run_time_s()
        self._system = System(
            self._words,
            folder=self._folder,
            probe=self._script.needs_ros(),
            longest_s=run_time_s + self._script.ready_limit_s() + STOP_ROOM_S,
        )
        self._narrator.begin(self._script, self._words, run_time_s)
        self._system.start()  # leaves nothing if it fails
        self._picture = Picture(self._system, self._folder, is_wanted=self._keeps_graph)
        try:
            self._narrator.started(self._system)
            self._watch()
            self._look_once_more()
        except KeyboardInterrupt as interrupt:
            self._interrupted = code_of(interrupt)
            self._narrator.say(self._now_s, "interrupted: stopping the system")
            self._picture.begin()
        finally:
            self._is_over.set()
            self._stop()
        return self._result()

    @property
    def _now_s(self) -> float:
        return self._system.recorder.now_s

    # ---- watching

    def _end_s(self, facts: Facts) -> float:
        """When the watching ends: `for` counts from when the system is ready."""
        if facts.ready_s is None:
            return INFINITY
        script = self._script
        if script.for_s is not None:
            return facts.ready_s + script.for_s
        return max(script.run_time_s(), facts.ready_s + SHORTEST_S)

    def _watch(self) -> None:
        system = self._system
        expectations = self._script.expectations
        if system.probe is not None:
            expectations = tuple(subscribed(system.probe, expectations))
            self._script = replace(self._script, expectations=expectations)
            AnswerPoller(system, self._is_over).begin(expectations)
        actor = CommandRunner(system, self._is_over)
        while system.is_alive and not self._gave_up:
            facts = system.facts()
            end_s = self._end_s(facts)
            if self._now_s >= end_s or self._has_seen_enough(facts):
                break
            self._check_ready(facts)
            self._act(actor, facts)
            self._look(facts, end_s)
            if self._now_s >= end_s - PICTURE_S:
                self._picture.begin()
            self._is_over.wait(LOOK_S)
        self._check_ready(system.facts())

    def _check_ready(self, facts: Facts) -> None:
        """Ready: what has to be there at the start is there, and a process runs."""
        if facts.ready_s is not None or self._gave_up:
            return
        limit_s = self._script.ready_limit_s()
        if facts.processes() and self._is_present(facts):
            self._system.recorder.step(READY)
            self._narrator.say(self._now_s, "ready")
        elif facts.now_s > limit_s:
            self._gave_up = True
            self._narrator.say(self._now_s, f"not ready after {seconds_text(limit_s)}: giving up")

    def _is_present(self, facts: Facts) -> bool:
        wanted = (replace(e, within=None) for e in self._script.presence())
        return all(judge(e, facts).outcome is Outcome.MET for e in wanted)

    def _look(self, facts: Facts, end_s: float) -> None:
        """Tell what is decided by now; thousands of expectations do not make the run longer."""
        if facts.now_s < self._next_look_s:
            return
        for expectation in self._script.expectations:
            if expectation.name in self._decided:
                continue
            if self._now_s >= end_s:
                break
            verdict = judge(expectation, facts)
            if verdict.outcome is not Outcome.OPEN:
                self._decided[expectation.name] = verdict
                self._narrator.decided(self._now_s, expectation, verdict)
        took_s = self._now_s - facts.now_s
        self._next_look_s = self._now_s + max(JUDGE_S, JUDGE_SHARE * took_s)

    def _has_seen_enough(self, facts: Facts) -> bool:
        """Whether nothing is left to wait for but the end itself, where no time is asked for."""
        script = self._script
        if script.for_s is not None or facts.now_s < SHORTEST_S or script.chaos is not None:
            return False
        moments = (moment for step in script.steps for moment in step.moments)
        is_open = (e for e in script.expectations if e.name not in self._decided)
        return (
            facts.ready_s is not None
            and all(moment in facts.steps for moment in moments)
            and all(e.kind in UNTIL_THE_END and e.within is None for e in is_open)
        )

    # ---- acting

    def _act(self, actor: CommandRunner, facts: Facts) -> None:
        for step in self._timeline.due(facts):
            self._do(actor, step)
        for stroke in () if self._strokes is None else self._strokes.due(facts):
            if stroke.process is None or not facts.lives(stroke.process, facts.now_s):
                text = f"chaos {stroke.number}: {stroke.command.text}: it does not run"
                self._narrator.say(self._now_s, text)
                continue
            self._narrator.say(self._now_s, f"chaos {stroke.number}: {stroke.command.text}")
            actor.do(stroke.command, self._tell_stroke)

    def _tell_stroke(self, error: str | None) -> None:
        if error is not None:
            self._narrator.say(self._now_s, f"chaos: {error}")

    def _do(self, actor: CommandRunner, step: Step) -> None:
        def done(error: str | None) -> None:
            if error is None:
                self._system.recorder.step(step.done)
                self._narrator.say(self._now_s, f"step: {step.command.text}")
            elif not self._is_over.is_set():
                self._failed_steps.append((step, error))
                self._narrator.say(self._now_s, f"step failed: {step.command.text}: {error}")

        def over() -> None:
            self._system.recorder.step(step.over)
            self._narrator.say(self._now_s, f"step: {step.command.text}: over")

        # Its effects may be seen before we know that it is done.
        self._system.recorder.step(step.name)
        actor.do(step.command, done, over)

    # ---- the end

    def _look_once_more(self) -> None:
        """At the system as it is before everything goes."""
        self._blind = probe_fault(self._system)
        if self._blind is not None:
            self._narrator.say(self._now_s, self._blind)
        self._picture.begin()

    def _stop(self) -> None:
        """Whatever happens: the system does not stay. A second Ctrl-C makes haste."""
        try:
            self._picture.finish_look()
            self._narrator.say(self._now_s, "stopping")
            has_children = bool(self._system.facts().processes())
            ending = self._system.stop(STOP_S if has_children else EMPTY_STOP_S)
        except KeyboardInterrupt as interrupt:
            self._interrupted = code_of(interrupt)
            ending = self._system.stop(0.0)
        self._narrator.ended(self._now_s, ending, self._system.facts())
        self._draw()

    def _draw(self) -> None:
        """What was seen of the graph, now that nothing waits for it."""
        try:
            why = self._picture.draw()
        except KeyboardInterrupt as interrupt:
            self._interrupted = code_of(interrupt)
            return
        if why is not None:
            self._system.recorder.add_trouble(why)

    def _result(self) -> Result:
        facts = self._system.facts()
        judged = [Judged(expectation=e, verdict=judge(e, facts)) for e in self._script.expectations]
        for one in judged:
            before = self._decided.get(one.expectation.name)
            if before is None or before.outcome is not one.verdict.outcome:
                self._narrator.decided(self._now_s, one.expectation, one.verdict)
        judged += _forced(judged, facts)
        judged += [_failed(step, error) for step, error in self._failed_steps]
        if not self._gave_up and not self._interrupted:
            judged += [_missed(step) for step in self._timeline.waiting]
        return Result(
            judged=tuple(judged),
            facts=facts,
            folder=self._folder,
            words=self._words,
            domain_id=self._system.domain_id,
            gave_up=self._gave_up,
            interrupted=self._interrupted,
            last_words=() if facts.processes() else tuple(self._system.last_words(WORDS)),
            trouble=self._trouble(facts),
        )

    def _trouble(self, facts: Facts) -> str | None:
        """What keeps a run from being trusted although all expectations are met."""
        ending = facts.ending
        assert ending is not None
        if ending.returncode is None:
            return "the launcher did not end and had to be killed"
        if ending.left_processes:
            return f"left behind, and killed by us: {', '.join(ending.left_processes)}"
        if not facts.processes():
            words = self._system.last_words(WORDS)
            errors = [word for word in words if word.startswith("error: ")]
            return (
                f"no process was started: {errors[0].removeprefix('error: ')}"
                if errors
                else ("no process was started")
            )
        if facts.lost_messages:
            return f"{facts.lost_messages} messages came too fast to be recorded"
        if self._blind is not None:
            return self._blind
        if self._script.needs_ros() and self._system.probe is None:
            return "nothing of ROS could be seen: " + "; ".join(facts.troubles)
        return None


def _forced(judged: Sequence[Judged], facts: Facts) -> list[Judged]:
    """A row of its own for what had to be killed at the stop, if no expectation tells of it."""
    verdict = forced_stop(facts)
    if verdict is None or any(one.expectation.kind == "clean_shutdown" for one in judged):
        return []
    expectation = Expectation(
        kind="stop",
        subject="*",
        name="nothing is stopped by force",
        implicit=True,
        origin=OF_EVERY_RUN,
    )
    return [Judged(expectation=expectation, verdict=verdict)]


def _failed(step: Step, error: str) -> Judged:
    return _of_step(step, Verdict(outcome=Outcome.VIOLATED, expected=_wanted(step), seen=error))


def _missed(step: Step) -> Judged:
    what = "the run was over before"
    if step.after_log is not None:
        what = f"no line with '{step.after_log.pattern}' came"
    return _of_step(step, Verdict(outcome=Outcome.VIOLATED, expected=_wanted(step), seen=what))


def _wanted(step: Step) -> str:
    return f"step '{step.command.text}' is done"


def _of_step(step: Step, verdict: Verdict) -> Judged:
    expectation = Expectation(
        kind="step", subject=step.name, name=f"step {step.name}", origin=step.origin
    )
    return Judged(expectation=expectation, verdict=verdict)


CLOCK_S = 5.0


def probe_fault(system: System) -> str | None:
    """A sentence if the probe does not answer: it may have missed what was to be seen.

    Everything that came before the answer has been told by then.
    """
    if system.probe is None:
        return None
    try:
        system.probe.ask("clock", timeout_s=CLOCK_S)
        found = system.probe.ask("services")["services"]
        system.recorder.set_services(service["name"] for service in found)
    except LauncherError as error:
        return f"{error.message}, so that not everything may have been seen"
    return None
