"""Ends a run: carries out the actions of its `ShutdownMachine`."""

from __future__ import annotations

import signal

from launcher.base.errors import ExitCode
from launcher.base.model.run_events import Stopping
from launcher.posix.cleanup import subreaper
from launcher.posix.reactor import Timer
from launcher.run.ending import shutdown_machine as rules
from launcher.run.ending.session_end import stop_session
from launcher.run.logs import messages
from launcher.run.processes.machine_events import MachineCommand, ReportExit
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.ending.leftovers import Leftovers
    from launcher.run.run import Run


class Shutdown:
    """Stops the processes of a run, then leftovers, then the reactor."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self.machine = rules.ShutdownMachine(
            run.all_processes.values(), exit_when_any_dies=run.options.exit_when_any_dies
        )
        self._processes = run.all_processes.values()
        self._reactor = run.reactor
        self._log = run.log
        self._driver = run.driver
        self._core = run.core_driver
        self._watchdog = run.watchdog
        self.has_cancelled = False  # a start that was queued
        self._leftovers: Leftovers | None = None
        self._sweeps = 0  # of this machine, and of the parts that look, that have not ended yet
        self._timer: Timer | None = None

    @property
    def has_begun(self) -> bool:
        return self.machine.is_stopping

    def causes(self) -> list[str]:
        """Why the exit code is not 0."""
        causes = self.machine.causes(has_lost_output=self._log.has_lost_output)
        return [self._run.launched.not_begun] if self._is_early and not causes else causes

    def exit_code(self) -> ExitCode:
        code = self.machine.exit_code(has_lost_output=self._log.has_lost_output)
        if code is ExitCode.OK and self._is_early:
            is_interrupt = self.machine.stop_signal == signal.SIGINT
            return ExitCode.INTERRUPTED if is_interrupt else ExitCode.TERMINATED
        return code

    @property
    def _is_early(self) -> bool:
        """Whether a signal has ended the run before anything was started."""
        if self.machine.stop_signal is None:
            return False
        is_empty = self.has_cancelled and not any(one.history.starts for one in self._processes)
        return is_empty or not self._run.is_begun

    # ---- events

    def interrupt(self, signum: int) -> None:
        self._handle(rules.Interrupted(signum))

    def output_closed(self) -> None:
        self._handle(rules.Occurrence.OUTPUT_CLOSED)

    def stop(self, reason: str) -> None:
        self._handle(rules.StopRequested(reason))

    def decided(self, reason: str, *, is_interrupted: bool = False) -> None:
        self._handle(rules.ShutdownDecided(reason, is_interrupted=is_interrupted))

    def ended(self, process: Process, end: ReportExit, *, is_required: bool) -> None:
        failure = messages.first_failure(process, end.outcome) if end.has_died else ""
        self._handle(rules.ProcessEnded(process.name, end, is_required=is_required, report=failure))

    def over_budget(self, process: Process, report: str) -> None:
        self._handle(rules.BudgetExceeded(process.name, report))

    def host_failed(self, cause: str) -> None:
        self._handle(rules.HostFailed(cause))

    def idle(self) -> None:
        """End the run if nothing is left to wait for."""
        self._core.settle_requests()
        self._handle(rules.Idle(self._core.expects_more, self._core.is_loading))

    def _handle(self, event: rules.ShutdownEvent) -> None:
        for action in self.machine.handle(event, self._reactor.now()):
            self._do(action)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        deadline = self.machine.deadline
        if deadline is not None:
            self._timer = self._reactor.call_later(deadline - self._reactor.now(), self._tick)

    def _tick(self) -> None:
        self._handle(rules.Occurrence.TICK)

    def _do(self, action: rules.ShutdownAction) -> None:
        match action:
            case rules.WriteLog(level=level, text=text):
                self._log.log(level, "launch", text)
            case rules.Notify(event=event):
                self._core.feed(event)
            case rules.StopAll(reason=reason, is_interrupted=is_interrupted):
                self._stop_all(
                    reason, MachineCommand.INTERRUPTED if is_interrupted else MachineCommand.STOP
                )
            case rules.ShutdownOrder.SKIP_GRACE_PERIODS:
                for process in list(self._processes):
                    self._driver.advance(process, MachineCommand.SKIP_GRACE)
                self._core.cancel_timers(all_of_them=True)
                self._reactor.call_later(0, self.idle)
                if self._leftovers is not None:
                    self._leftovers.skip_grace()
                for part in self._run.parts:
                    part.skip_grace()
            case rules.ShutdownOrder.REPORT_WAITING:
                now = self._reactor.now()
                waiting = messages.waiting_for(self._processes, now)
                self._log.log("INFO", "launch", waiting)
            case rules.EndLeftovers(skipped=skipped):
                self._end_leftovers(skipped)
            case rules.ShutdownOrder.FINISH:
                self._reactor.stop()

    def _stop_all(self, reason: str, how: MachineCommand) -> None:
        self._log.note(Stopping(reason))
        if self._core.cancel_timers():
            text = "waiting for a timer with cancel_on_shutdown=False; Ctrl-C cancels it"
            self._log.log("INFO", "launch", text)
        self._watchdog.prepare_end()
        for process in reversed(list(self._processes)):
            self._driver.advance(process, how)
        for part in self._run.parts:
            part.stopping()
        self._reactor.call_later(0, self.idle)

    # ---- leftovers

    def _end_leftovers(self, skipped: int) -> None:
        from launcher.run.ending.leftovers import Leftovers, stop_policy_for

        self.end_helpers()
        self._watchdog.prepare_end()
        processes = self._processes
        here = (process for process in processes if process.host is None)
        stuck = (process.child for process in here if process.machine.is_stuck)
        stuck_pids = frozenset(child.pid for child in stuck if child is not None)
        self._leftovers = Leftovers(
            self._run.id,
            reactor=self._reactor,
            listener=self,
            ignore=self._watchdog.pids | stuck_pids,  # those have been reported already
            policy=stop_policy_for(process.machine.stop for process in processes),
            kin=subreaper.orphans,
        )
        self._sweeps = 1
        for part in self._run.parts:
            self._sweeps += part.finish(self.finished)
        self._leftovers.check()
        for _ in range(skipped):
            self._leftovers.skip_grace()

    def end_helpers(self) -> None:
        """End helper processes of the launcher, which must not count as leftovers."""
        self._core.close_requests()
        for part in self._run.parts:
            part.end_helpers()

    def end_session(self, process: Process, session: int) -> None:
        """Stop what a process that was stopped, or is restarted, left in its session.

        If a user has stopped it, and the rest must be killed, the run has not failed.
        """
        if self.has_begun:
            return
        by_user = process.machine.is_held
        stop_session(
            session,
            run_id=self._run.id,
            reactor=self._reactor,
            ignore=self._watchdog.pids,
            stop=process.machine.stop,
            log=lambda level, text: self._log.log(level, process.name, text),
            killing=(lambda: None) if by_user else self.killing,
        )

    def report(self, level: str, text: str) -> None:
        self._log.log(level, "launch", text)

    def killing(self) -> None:
        self._handle(rules.Occurrence.LEFTOVERS_KILLED)

    def finished(self) -> None:
        self._sweeps -= 1
        if self._sweeps == 0:
            for process in self._processes:
                self._driver.read_rest(process)
            self._handle(rules.Occurrence.LEFTOVERS_GONE)
