"""Once a second: samples resources, checks the log folder, frees shared memory.

Samples of more than `PROCESSES_PER_S` processes are taken less often: `sample_period_s`.
"""

from __future__ import annotations

import math

from launcher.base.model.run_events import Resources
from launcher.posix.cleanup import subreaper
from launcher.run.monitor.ledger import Ledger
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from launcher.base.model.run_events import Sample
    from launcher.posix.reactor import Reactor, Timer
    from launcher.run.logs.run_log import RunLog
    from launcher.run.monitor.resources import Sampler, Steps
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

PERIOD_S = 1.0
# So the samples of any number take about a hundredth of a core, and events.jsonl, which has them
# all, does not push out what has happened.
PROCESSES_PER_S = 100
SLICE_S = 0.0005  # of sampling, before the loop reads lines again
COLLECT_S = 0.01  # a thread is reading /proc/locks


class Housekeeper:
    """`processes` is the live collection of those of the run.

    `more()` are samples of processes elsewhere, by name; `on_samples(samples, processes)` is called
    with all of a round, by name. `ledger` has the shared memory of the run.
    """

    def __init__(
        self,
        reactor: Reactor,
        log: RunLog,
        run_id: str,
        processes: Collection[Process],
        *,
        more: Callable[[], Mapping[str, Sample]] = dict,
        on_samples: Callable[[Mapping[str, Sample], Mapping[str, Process]], None] | None = None,
    ) -> None:
        self._reactor = reactor
        self._log = log
        self._processes = processes
        self._more = more
        self._on_samples = on_samples
        self._sampler: Sampler | None = None
        self._sampling: dict[int, Process] = {}  # of the current round, by pid
        self.ledger = Ledger(run_id)  # before the processes make anything
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

    def ended(self, process: Process) -> None:
        """Free what it has left of shared memory, if its end was a death."""
        code = None if process.last_end is None else process.last_end.outcome.returncode
        if code and process.host is None:
            self.ledger.died(code, process.begun_wall_s)

    def sample_of(self, process: Process) -> Sample | None:
        """Its last sample; None if there is none yet, or if it is not running."""
        sample = self.samples.get(process.name)
        if process.child is None or sample is None or sample.pid != process.child.pid:
            return None
        return sample

    def close(self) -> None:
        for timer in (self._timer, self._collecting):
            if timer is not None:
                timer.cancel()
        self.ledger.collect()
        self._free(is_last=True)

    def _tick(self) -> None:
        begun_s = self._reactor.now()
        self.ledger.keep_up(begun_s)
        self._collect()
        self._log.keep_up()
        subreaper.adopted()  # reaps those that have exited
        self._free()
        if self._sampler is None:
            from launcher.run.monitor.resources import Sampler  # most processes run by now

            self._sampler = Sampler(self._saw_state)
        # The tick may be a little early.
        if begun_s < self._sampled_s + self.sample_period_s - PERIOD_S / 2:
            self._rest_after(begun_s)
            return
        self._sampled_s = begun_s
        self._sampling = self._living()
        guests = {guest: pid for pid, one in self._sampling.items() for guest in one.guests}
        steps = self._sampler.steps(self._sampling, self._reactor.now, guests)
        self._timer = self._reactor.call_later(0, lambda: self._continue(steps, begun_s))

    def _collect(self) -> None:
        self.ledger.collect()
        if self.ledger.is_reading:
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
            self._sampled(end.value)
            return
        self._timer = self._reactor.call_later(wait_s, lambda: self._continue(steps, begun_s))

    def _saw_state(self, pid: int, is_suspended: bool) -> None:
        process = self._sampling.get(pid)
        if process is not None and process.child is not None and process.child.pid == pid:
            process.saw_state(is_suspended=is_suspended)

    def _sampled(self, found: dict[int, Sample]) -> None:
        # A process may have exited, or restarted, while the others were sampled.
        living = self._living()
        self.samples = {living[pid].name: found[pid] for pid in found if pid in living}
        self.samples.update(self._more())
        by_name = {p.name: p for p in self._processes if p.name in self.samples}
        for name, sample in self.samples.items():
            by_name[name].history.sampled(sample.uss_bytes)
        if self.samples:
            self._log.note(Resources(dict(self.samples)))
        if self._on_samples is not None:
            self._on_samples(self.samples, by_name)

    def _living(self) -> dict[int, Process]:
        """The running processes of this machine, by pid."""
        ours = (process for process in self._processes if process.host is None)
        return {process.child.pid: process for process in ours if process.child is not None}

    def _free(self, *, is_last: bool = False) -> None:
        freed = self.ledger.free(is_last=is_last)
        if freed:
            text = f"freed {freed / 1e6:.1f} MB of shared memory of killed nodes"
            self._log.log("INFO", "launch", text)


class Housekeeping(Part):
    """The housekeeper of a run."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self.keeper = Housekeeper(
            run.reactor,
            run.log,
            run.id,
            run.all_processes.values(),
            more=self._more,
            on_samples=self._sampled,
        )
        for process in run.all_processes.values():
            self.keeper.ended(process)  # it may have, before this was imported

    def _more(self) -> dict[str, Sample]:
        return {name: one for part in self.run.parts for name, one in part.samples().items()}

    def _sampled(self, samples: Mapping[str, Sample], processes: Mapping[str, Process]) -> None:
        for part in self.run.parts:
            part.sampled(samples, processes)

    def begin(self) -> None:
        self.keeper.start()

    def ended(self, process: Process, end: ReportExit) -> None:
        self.keeper.ended(process)

    def conclude(self, *, is_orderly: bool) -> None:
        self.keeper.close()

    def close(self) -> None:
        self.keeper.ledger.release()  # the helpers have ended, too
