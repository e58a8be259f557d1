"""One smoke run, from the lease of a ROS domain to the verdicts. Its duration is bounded."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import FrameType

from launcher.base.document.quantities import INFINITY, seconds_text
from launcher.base.errors import ExitCode, LauncherError
from launcher.base.text import several
from launcher.posix.dispositions import Handled
from launcher.smoke.expect.evaluator import EVALUATOR
from launcher.smoke.expect.expectation import READY, Decision, Expectation, Verdict
from launcher.smoke.expect.expectation_kinds import KINDS
from launcher.smoke.expect.script import MIN_RUN_S, OF_EVERY_RUN, Script
from launcher.smoke.judges import judge
from launcher.smoke.judges.run import forced_stop
from launcher.smoke.observe.facts import Facts
from launcher.smoke.preflight.forecast import Forecast
from launcher.smoke.reports.graph_files import GraphFiles
from launcher.smoke.reports.moments import LiveExpectations
from launcher.smoke.reports.result import Judged, SmokeResult
from launcher.smoke.run.pending_starts import lost
from launcher.smoke.run.probe_requests import AnswerPoller, subscribed
from launcher.smoke.run.scenario import Scenario
from launcher.smoke.run.smoke_progress import SmokeProgress
from launcher.smoke.run.system import STOP_S, System

POLL_S = 0.1
JUDGE_S = 0.5  # judging all messages of a long run takes time
JUDGE_SHARE = 4  # judge again after at least so many times what the last judging took
GRAPH_RECORD_S = 1.0  # before the end, the graph is recorded if there is no probe
STOP_ROOM_S = 15.0  # the launcher times out this long after it should have been stopped
EMPTY_STOP_S = 5.0  # a launcher without processes has nothing to wait for
PROBE_ANSWER_S = 5.0
LAST_LINES = 200  # of a launcher that has started nothing: they have the reason
# Without a time limit, these are decided by the end, whenever that is.
UNTIL_THE_END = {"no_deaths", "like", "clean_shutdown", "shared_memory"}
UNTIL_THE_END |= {kind.name for kind in KINDS if kind.of_process}


class Terminated(KeyboardInterrupt):
    """A signal other than Ctrl-C; it only differs in the exit code."""


def code_of(interrupt: KeyboardInterrupt) -> ExitCode:
    return ExitCode.TERMINATED if isinstance(interrupt, Terminated) else ExitCode.INTERRUPTED


@contextlib.contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM, SIGHUP and SIGQUIT stop the system, as Ctrl-C does."""

    def interrupt(signum: int, frame: FrameType | None) -> None:
        raise Terminated

    with Handled(interrupt, (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)):
        yield


class Runner:
    """Runs a script once. `words` are the target and the options for the launcher.

    `keeps_graph`: record the ROS graph even if no expectation needs it. `judge` is called with what
    will be started, before anything is, and may refuse it by a LauncherError. `always_probed`:
    observe ROS even if no expectation needs it. `keeps_page`: keep what a page shows.
    """

    def __init__(
        self,
        script: Script,
        words: Sequence[str],
        folder: Path,
        progress: SmokeProgress,
        *,
        keeps_graph: bool = False,
        judge: Callable[[Forecast], None] | None = None,
        always_probed: bool = False,
        keeps_page: bool = False,
    ) -> None:
        self._script = script.completed()
        self._is_probed = always_probed or self._script.needs_ros()
        self._words = tuple(words)
        self._folder = folder
        self._progress = progress
        self._is_over = threading.Event()
        self._decided: dict[str, tuple[Verdict, float]] = {}  # with the time
        self._live: LiveExpectations | None = None
        self._gave_up = False
        self._probe_fault: str | None = None
        self._interrupted: ExitCode | None = None
        self._next_judging_s = 0.0
        self._run_time_s = self._script.run_time_s()
        self._system = System(
            self._words,
            folder=folder,
            probe=self._is_probed or keeps_page,
            keeps_graphs=keeps_page,
            records=self._script.recorded_topics(),
            longest_s=self._run_time_s + self._script.ready_limit_s() + STOP_ROOM_S,
            judge=judge,
        )
        self._scenario = Scenario(self._script, self._system, progress, self._is_over)
        self._graph_files = GraphFiles(self._system, folder, always=keeps_graph)

    @property
    def forecast(self) -> Forecast | None:
        """What the launch file starts, if it was asked for and is known."""
        return self._system.forecast

    def run(self) -> SmokeResult:
        """Start, observe, stop, judge. Ctrl-C stops the system, too.

        LauncherError if the `judge` refuses what would be started.
        """
        self._progress.begin(self._script, self._words, self._run_time_s)
        self._system.start()  # leaves nothing behind if it fails
        try:
            self._progress.started(self._system)
            self._observe()
            self._check_probe()
            self._graph_files.begin()
        except KeyboardInterrupt as interrupt:
            self._interrupted = code_of(interrupt)
            self._say("interrupted: stopping the system")
            self._graph_files.begin()
        finally:
            self._is_over.set()
            self._stop()
        try:
            return self._result()
        finally:
            EVALUATOR.close()

    @property
    def _now_s(self) -> float:
        return self._system.recorder.now_s

    def _say(self, text: str) -> None:
        self._progress.log(self._now_s, text)

    # ---- observing

    def _end_s(self, facts: Facts) -> float:
        """`for` counts from when the system is ready."""
        if facts.ready_s is None:
            return INFINITY
        if self._script.for_s is not None:
            return facts.ready_s + self._script.for_s
        return max(self._run_time_s, facts.ready_s + MIN_RUN_S)

    def _observe(self) -> None:
        system = self._system
        if system.probe is not None:
            expectations = tuple(subscribed(system.probe, self._script.expectations))
            self._script = replace(self._script, expectations=expectations)
            AnswerPoller(system, self._is_over).begin(expectations)
        while system.is_alive and not self._gave_up:
            facts = system.facts()
            end_s = self._end_s(facts)
            if self._now_s >= end_s or self._is_decided(facts):
                break
            self._check_ready(facts)
            self._accompany(facts)
            self._scenario.run_due(facts)
            self._judge(facts, end_s)
            if self._now_s >= end_s - GRAPH_RECORD_S:
                self._graph_files.begin()
            self._is_over.wait(POLL_S)
        self._check_ready(system.facts())

    def _accompany(self, facts: Facts) -> None:
        """Called again and again while the system is observed; for subclasses."""

    def _check_ready(self, facts: Facts) -> None:
        """Ready: a process runs, none waits for others or for its own facts (`ready_when`), and
        all expectations for the start are met.
        """
        if facts.ready_s is not None or self._gave_up:
            return
        limit_s = self._script.ready_limit_s()
        presence = self._script.presence()
        if facts.processes() and self._is_ready(facts):
            self._system.recorder.step(READY)
            self._say("ready")
        elif facts.now_s > limit_s:
            self._give_up(f"not ready after {seconds_text(limit_s)}{self._unready_text(facts)}")
        elif hopeless := lost(presence, facts, self.forecast, self._scenario.waiting):
            assert hopeless.within is not None
            time_s = seconds_text(hopeless.within.high)
            why = f"'{hopeless.name}' was not met within {time_s}, and nothing else will be started"
            self._give_up(f"not ready: {why}")

    def _is_ready(self, facts: Facts) -> bool:
        if facts.unready():
            return False
        wanted = (replace(e, within=None) for e in self._script.presence())
        return all(judge(e, facts).outcome is Decision.MET for e in wanted)

    def _unready_text(self, facts: Facts) -> str:
        """What is missing, after `not ready after 10.0 s`."""
        names = facts.unready()
        return f": not ready: {several(names)}" if names else ""

    def _give_up(self, reason: str) -> None:
        self._gave_up = True
        self._say(f"{reason}: giving up")

    def _judge(self, facts: Facts, end_s: float) -> None:
        """Report what is decided; thousands of expectations do not make the run longer."""
        if facts.now_s < self._next_judging_s:
            return
        for expectation in self._script.expectations:
            if expectation.name in self._decided:
                continue
            if self._now_s >= end_s:
                break
            verdict = judge(expectation, facts)
            if verdict.outcome is not Decision.OPEN:
                self._decided[expectation.name] = verdict, facts.now_s
                self._progress.decided(self._now_s, expectation, verdict)
        self._publish()
        took_s = self._now_s - facts.now_s
        self._next_judging_s = self._now_s + max(JUDGE_S, JUDGE_SHARE * took_s)

    def _publish(self) -> None:
        """Show what is decided on the page of the run."""
        if self._live is None and (folder := self._system.log_dir) is not None:
            self._live = LiveExpectations(folder, self._system.recorder)
        if self._live is not None:
            self._live.write(self._script.expectations, self._decided)

    def _is_decided(self, facts: Facts) -> bool:
        """Whether only the end itself is left to wait for, and no duration is given."""
        script = self._script
        if script.for_s is not None or script.chaos is not None:
            return False
        if facts.now_s < script.least_run_s():
            return False
        recorded_s = facts.now_s - (facts.ready_s or 0.0)
        if any(recorded_s < likeness.duration_s for likeness in script.likenesses()):
            return False
        is_open = (e for e in script.expectations if e.name not in self._decided)
        return (
            facts.ready_s is not None
            and all(moment in facts.steps for moment in script.moments())
            and all(e.kind in UNTIL_THE_END and e.within is None for e in is_open)
        )

    def _check_probe(self) -> None:
        """A probe that does not answer may have missed something.

        Its answer comes after all that it has reported before.
        """
        probe = self._system.probe
        if probe is None:
            return
        try:
            probe.ask("clock", timeout_s=PROBE_ANSWER_S)
            found = probe.ask("services")["services"]
            self._system.recorder.set_services(service["name"] for service in found)
        except LauncherError as error:
            self._probe_fault = f"{error.message}; observations may be missing"
            self._say(self._probe_fault)

    # ---- the end

    def _stop(self) -> None:
        """The system is stopped in any case; a second Ctrl-C kills it."""
        try:
            self._graph_files.finish_recording()
            self._say("stopping")
            has_children = bool(self._system.facts().processes())
            ending = self._system.stop(STOP_S if has_children else EMPTY_STOP_S)
        except KeyboardInterrupt as interrupt:
            self._interrupted = code_of(interrupt)
            ending = self._system.stop(0.0)
        self._progress.ended(self._now_s, ending, self._system.facts())
        try:
            fault = self._graph_files.draw()
        except KeyboardInterrupt as interrupt:
            self._interrupted = code_of(interrupt)
        else:
            if fault is not None:
                self._system.recorder.add_trouble(fault)

    def _result(self) -> SmokeResult:
        facts = self._system.facts()
        judged = [self._judged(e, facts) for e in self._script.expectations]
        for one in judged:
            if one.decided_s is None:
                self._progress.decided(self._now_s, one.expectation, one.verdict)
        judged += _forced(judged, facts)
        is_complete = not self._gave_up and not self._interrupted
        judged += self._scenario.failures(with_waiting=is_complete)
        return SmokeResult(
            judged=tuple(judged),
            facts=facts,
            folder=self._folder,
            words=self._words,
            domain_id=self._system.domain_id,
            gave_up=self._gave_up,
            interrupted=self._interrupted,
            last_lines=() if facts.processes() else tuple(self._system.last_lines(LAST_LINES)),
            trouble=self._trouble(facts),
            started_s=self._system.recorder.wall_of(0.0),
            last_state=self._system.last_state,
        )

    def _judged(self, expectation: Expectation, facts: Facts) -> Judged:
        verdict = judge(expectation, facts)
        before, at_s = self._decided.get(expectation.name, (None, None))
        is_new = before is None or before.outcome is not verdict.outcome
        return Judged(expectation=expectation, verdict=verdict, decided_s=None if is_new else at_s)

    def _trouble(self, facts: Facts) -> str | None:
        """Why the run has failed although all expectations may be met."""
        ending = facts.ending
        assert ending is not None
        if ending.returncode is None:
            return "the launcher did not exit and was killed"
        if ending.left_processes:
            return f"left behind and killed: {', '.join(ending.left_processes)}"
        if not facts.processes():
            lines = self._system.last_lines(LAST_LINES)
            errors = [line for line in lines if line.startswith("error: ")]
            reason = f": {errors[0].removeprefix('error: ')}" if errors else ""
            return f"no process was started{reason}"
        if facts.lost_messages:
            return f"{facts.lost_messages} messages came too fast to be recorded"
        if self._probe_fault is not None:
            return self._probe_fault
        if self._is_probed and self._system.probe is None:
            return "ROS could not be observed: " + "; ".join(facts.troubles)
        return None


def _forced(judged: Sequence[Judged], facts: Facts) -> list[Judged]:
    """A row for what was killed or crashed at the stop, unless a `clean_shutdown` reports it."""
    verdict = forced_stop(facts)
    if verdict is None or any(one.expectation.kind == "clean_shutdown" for one in judged):
        return []
    expectation = Expectation(
        kind="stop",
        subject="*",
        name="no process is killed at the stop",
        implicit=True,
        origin=OF_EVERY_RUN,
    )
    return [Judged(expectation=expectation, verdict=verdict)]
