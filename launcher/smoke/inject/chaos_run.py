"""Carries out a plan of injections in a run: `--chaos FILE`."""

from __future__ import annotations

import itertools
from collections.abc import Callable

from launcher.base.run_verb import BadCallError
from launcher.run.part import Part
from launcher.run.processes.machine_events import ProcessState
from launcher.run.requests.process_selection import ProcessNames, resolve
from launcher.smoke.inject import chaos_plan
from launcher.smoke.inject.chaos_plan import PlannedInjection
from launcher.smoke.inject.grammar import MACHINE
from launcher.smoke.inject.injections import Injections

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions
    from launcher.posix.reactor import Timer
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

POLL_S = 0.1  # until the system is ready
SHOWN = 5  # planned injections in the log


def check(options: RunOptions) -> None:
    """LauncherError for a file with mistakes: before anything is started."""
    if options.chaos_plan is not None:
        chaos_plan.load(options.chaos_plan)


class ChaosRun(Part):
    """Begins each injection when it is due; one that is not possible then is left out."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        assert run.options.chaos_plan is not None
        self._plan = chaos_plan.load(run.options.chaos_plan)
        self._steps = self._plan.steps()
        self._began_s = 0.0
        self._timer: Timer | None = None

    def begin(self) -> None:
        self._log(f"seed {self._plan.seed}: {', '.join(map(_planned, self._first()))}")
        for entry in self._plan.entries:
            if entry.name != MACHINE and not self._named(entry.name):
                self.run.log.warn(f"chaos: there is no process '{entry.name}' yet")
        if self._plan.start_s is None:
            self._await_ready()
        else:
            self._timer = self.run.reactor.call_later(self._plan.start_s, self._begin_plan)

    def _first(self) -> list[PlannedInjection]:
        return list(itertools.islice(self._plan.steps(), SHOWN))

    def _log(self, text: str) -> None:
        self.run.log.log("INFO", "launch", f"chaos: {text}")

    def _await_ready(self) -> None:
        if all(map(self._is_ready, self.run.processes)):
            self._begin_plan()
        else:
            self._timer = self.run.reactor.call_later(POLL_S, self._await_ready)

    def _is_ready(self, process: Process) -> bool:
        """Whether it runs, and what it needs for that holds, or it has ended."""
        if process.machine.state is ProcessState.STARTING:
            return False
        rows = (part.row(process) for part in self.run.parts)
        return process.child is None or not any(row.get("lacks") for row in rows)

    def _begin_plan(self) -> None:
        self._began_s = self.run.reactor.now()
        self._next()

    def _next(self) -> None:
        step = next(self._steps, None)
        if step is None:
            self._at(self._plan.for_s or 0.0, lambda: self._log("the plan is over"))
        else:
            self._at(step.at_s, lambda: self._do(step))

    def _at(self, at_s: float, call: Callable[[], None]) -> None:
        """Call it so long after the start of the plan, or now if that has passed."""
        wait_s = self._began_s + at_s - self.run.reactor.now()
        self._timer = self.run.reactor.call_later(max(0.0, wait_s), call)

    def _do(self, step: PlannedInjection) -> None:
        self._inject(step)
        self._next()

    def _inject(self, step: PlannedInjection) -> None:
        process = None
        if step.name != MACHINE:
            found = {one.name: one for one in self._named(step.name)}
            name = step.target(sorted(found))
            if name is None:
                self._log(f"{step.number}: no process '{step.name}'")
                return
            process = found[name]
        text = f"{step.number}: {step.text}"

        def done(problem: str | None) -> None:
            if problem is not None:
                self._log(f"{text}: {problem}")

        try:
            self._log(text + ("" if process is None else f", {process.name}"))
            self.run.parts.need(Injections).begin_one(step.injection, process, done)
        except BadCallError as error:
            self._log(f"{text}: {error.message}")

    def _named(self, word: str) -> list[Process]:
        """All processes of the launch file with this name, running or not."""
        processes = self.run.processes
        try:
            places = resolve([word], [ProcessNames.of(one.spec) for one in processes])
        except BadCallError:
            return []
        return [processes[place] for place in places]

    def stopping(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._steps = iter(())


def _planned(step: PlannedInjection) -> str:
    return f"{step.at_s:.1f} s {step.text}"
