"""Carries out the actions of budgets: `--budget`, and the file of `--supervise`."""

from __future__ import annotations

from launcher.base.model.run_events import OverBudget
from launcher.base.model.run_options import names_of
from launcher.run.monitor import budget_parser
from launcher.run.monitor.budgets import BudgetAction, Judge
from launcher.run.part import Part
from launcher.run.processes.machine_events import MachineCommand

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping

    from launcher.base.model.run_events import Sample
    from launcher.base.model.run_options import RunOptions
    from launcher.run.monitor.budgets import BudgetExcess
    from launcher.run.processes.process import Process
    from launcher.run.run import Run


class BudgetEnforcement(Part):
    """Made before anything is started: UsageError if a budget is invalid."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._judge = judge_for(run.options)

    def follow(self, before: RunOptions) -> None:
        if self.run.options.file_budgets != before.file_budgets:
            self._judge = judge_for(self.run.options)

    def sampled(self, samples: Mapping[str, Sample], processes: Mapping[str, Process]) -> None:
        names = {name: names_of(process.spec) for name, process in processes.items()}
        for verdict in self._judge.judge(samples, self.run.reactor.now(), names):
            self._enforce(processes[verdict.process], verdict)

    def _enforce(self, process: Process, verdict: BudgetExcess) -> None:
        """Carry out the action; under a debugger the excess is only reported."""
        is_debugged = process.debugger is not None
        but = "; nothing is done, since it is under a debugger" if is_debugged else ""
        self.run.log.log("WARNING", process.name, f"{verdict}{but}")
        self.run.log.note(OverBudget(verdict.action.value), process)
        if is_debugged:
            return
        if verdict.action is BudgetAction.RESTART:
            self.run.driver.advance(process, MachineCommand.RESTART)
        elif verdict.action is BudgetAction.STOP_RUN:
            self.run.shutdown.over_budget(process, str(verdict))


def judge_for(options: RunOptions) -> Judge:
    return Judge([*budget_parser.parse_words(options.budgets), *options.file_budgets])
