"""Once a second: samples resources, checks budgets and the log folder, frees shared memory.

Samples of more than `PROCESSES_PER_S` processes are taken less often: `sample_period_s`.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from launcher.base.model.options import RunOptions, names_of
from launcher.base.model.run_events import OverBudget, Resources
from launcher.posix.cleanup import subreaper
from launcher.posix.reactor import Reactor, Timer
from launcher.run.logs.run_log import RunLog
from launcher.run.machine import Command
from launcher.run.monitor.ledger import Ledger
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_events import Sample
    from launcher.hosts.engine.fleet import Fleet
    from launcher.run.listener import RunListener
    from launcher.run.monitor.budgets import Judge, Verdict
    from launcher.run.monitor.resources import Sampler, Steps
    from launcher.run.process_driver import ProcessDriver
    from launcher.run.shutdown import Shutdown

PERIOD_S = 1.0
# So the samples of any number take about a hundredth of a core, and events.jsonl, which has them
# all, does not push out what has happened.
PROCESSES_PER_S = 100
SLICE_S = 0.0005  # of sampling, before the loop reads lines again
COLLECT_S = 0.01  # a thread is reading /proc/locks


class Housekeeper:
    """`processes` is the live collection of those of the run."""

    def __init__(
        self,
        reactor: Reactor,
        log: RunLog,
        listener: RunListener,
        *,
        run_id: str,
        processes: Collection[Process],
        judge: Judge | None = None,
        fleet: Fleet | None = None,
    ) -> None:
        self._reactor = reactor
        self._log = log
        self._listener = listener
        self._processes = processes
        self.judge = judge
        self._fleet = fleet
        self._sampler: Sampler | None = None
        self._ledger = Ledger(run_id)  # before the processes make anything
        self._timer: Timer | None = None
        self._collecting: Timer | None = None
        self._sampled_s = -math.inf
        self.samples: dict[str, Sample] = {}

    def start(self) -> None:
        self._timer = self._reactor.call_later(PERIOD_S, self._tick)

    @property
    def sample_period_s(self) -> float:
        """Seconds between samples, for the number of processes that are running now."""
        return max(PERIOD_S, math.ceil(len(self._living()) / PROCESSES_PER_S))

    def note_shared_memory(self) -> None:
        """Record the shared memory of processes right before a SIGKILL, to free it afterwards."""
        self._ledger.note()

    def add_helper(self, pid: int) -> None:
        """Free the shared memory of this helper process, too."""
        self._ledger.helper_pids.add(pid)

    def died(self, returncode: int, since_s: float) -> None:
        """A process exited by a signal or with an error: free what it left of shared memory."""
        self._ledger.died(returncode, since_s)

    def close(self) -> None:
        for timer in (self._timer, self._collecting):
            if timer is not None:
                timer.cancel()
        self._ledger.collect()
        self._free(is_last=True)

    def release(self) -> None:
        """Free the shared memory that is left when the helpers have ended, too; after `close`."""
        self._ledger.release()

    def _tick(self) -> None:
        begun_s = self._reactor.now()
        self._ledger.keep_up(begun_s)
        self._collect()
        self._log.keep_up()
        subreaper.adopted()  # reaps those that have exited
        self._free()
        if self._sampler is None:
            from launcher.run.monitor.resources import Sampler  # most processes run by now

            self._sampler = Sampler()
        # The tick may be a little early.
        if begun_s < self._sampled_s + self.sample_period_s - PERIOD_S / 2:
            self._rest_after(begun_s)
            return
        self._sampled_s = begun_s
        pids = list(self._living())
        steps = self._sampler.steps(pids, self._reactor.now)
        self._timer = self._reactor.call_later(0, lambda: self._continue(steps, begun_s))

    def _collect(self) -> None:
        self._ledger.collect()
        if self._ledger.is_reading:
            self._collecting = self._reactor.call_later(COLLECT_S, self._collect)

    def _rest_after(self, begun_s: float) -> None:
        wait_s = begun_s + PERIOD_S - self._reactor.now()
        self._timer = self._reactor.call_later(max(0.0, wait_s), self._tick)

    def _continue(self, steps: Steps, begun_s: float) -> None:
        """Take some steps of sampling; the next ones after the loop has read lines."""
        until_s = self._reactor.now() + SLICE_S
        wait_s = 0.0
        try:
            while not wait_s and self._reactor.now() < until_s:
                wait_s = next(steps)
        except StopIteration as end:
            self._rest_after(begun_s)
            self._sampled(end.value, begun_s)
            return
        self._timer = self._reactor.call_later(wait_s, lambda: self._continue(steps, begun_s))

    def _sampled(self, found: dict[int, Sample], now: float) -> None:
        # A process may have exited, or restarted, while the others were sampled.
        living = self._living()
        self.samples = {living[pid].name: found[pid] for pid in found if pid in living}
        if self._fleet is not None:
            self.samples.update(self._fleet.samples())
        by_name = {p.name: p for p in self._processes if p.name in self.samples}
        for name, sample in self.samples.items():
            by_name[name].history.sampled(sample.uss_bytes)
        if self.samples:
            self._log.note(Resources(dict(self.samples)))
        if self.judge is not None:
            names = {name: names_of(process.spec) for name, process in by_name.items()}
            for verdict in self.judge.judge(self.samples, now, names):
                self._listener.over_budget(by_name[verdict.process], verdict)

    def _living(self) -> dict[int, Process]:
        """The running processes of this machine, by pid."""
        ours = (process for process in self._processes if process.host is None)
        return {process.child.pid: process for process in ours if process.child is not None}

    def _free(self, *, is_last: bool = False) -> None:
        freed = self._ledger.free(is_last=is_last)
        if freed:
            text = f"freed {freed / 1e6:.1f} MB of shared memory of killed nodes"
            self._log.log("INFO", "launch", text)


def enforce(
    process: Process, verdict: Verdict, log: RunLog, driver: ProcessDriver, shutdown: Shutdown
) -> None:
    """Carry out the action of a budget that a process has exceeded for too long.

    Under a debugger it is only told.
    """
    from launcher.run.monitor.budgets import BudgetAction

    is_debugged = process.debugger is not None
    but = "; nothing is done, since it is under a debugger" if is_debugged else ""
    log.log("WARNING", process.name, f"{verdict}{but}")
    log.note(OverBudget(verdict.action.value), process)
    if is_debugged:
        return
    if verdict.action is BudgetAction.RESTART:
        driver.advance(process, Command.RESTART)
    elif verdict.action is BudgetAction.STOP_RUN:
        shutdown.over_budget(process, str(verdict))


def judge_for(options: RunOptions) -> Judge:
    """The judge for the budgets of this run; UsageError if one is invalid."""
    from launcher.run.monitor import budget_parser
    from launcher.run.monitor.budgets import Judge

    return Judge([*budget_parser.parse_words(options.budgets), *options.file_budgets])
