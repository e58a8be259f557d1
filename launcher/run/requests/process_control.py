"""Carries out requests of users for single processes, and reports the results as data."""

from __future__ import annotations

import functools

from launcher.base.model import run_events
from launcher.base.model.record import replace
from launcher.run.part import Part
from launcher.run.processes.machine_events import MachineCommand, ProcessState, ReportExit
from launcher.run.processes.process import Process
from launcher.run.requests.process_signals import (
    ProcessSignals,
    may_restart,
    not_running,
    unreachable,
)
from launcher.run.requests.request_queue import (
    Act,
    Answer,
    Do,
    Done,
    ProcessPhase,
    ProcessRequest,
    Purpose,
    QueueAction,
    RequestOrder,
    RequestQueue,
    RequestStep,
    Situation,
)
from launcher.run.requests.request_result import Kind, Result

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from launcher.run.run import Run


class ProcessControl(Part):
    """Calls `done(result)` of each request when it is complete.

    A request that waits is carried out only as long as nobody calls `withdraw` with it.
    """

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._driver = run.driver
        self._log = run.log
        self._shutdown = run.shutdown
        self._queues: dict[Process, RequestQueue] = {}
        self._signals = ProcessSignals(run.reactor, run.driver, run.log)

    # ---- requests that wait for each other

    def stop(self, process: Process, done: Done) -> ProcessRequest:
        """Stop it by its stop policy; it may be started again."""
        return self.ask(process, ProcessRequest(Purpose.STOP, done))

    def start(self, process: Process, done: Done) -> ProcessRequest:
        """Start it if it is not running; its restarts are counted from 0 again."""
        return self.ask(process, ProcessRequest(Purpose.START, done))

    def restart(self, process: Process, done: Done) -> ProcessRequest:
        """Stop it if it runs, then start it."""
        return self.ask(process, ProcessRequest(Purpose.RESTART, done))

    def suspend(self, process: Process, done: Done) -> ProcessRequest:
        return self._act(process, self._signals.suspend, done)

    def resume(self, process: Process, done: Done) -> ProcessRequest:
        return self._act(process, self._signals.resume, done, is_urgent=True)

    def send(self, process: Process, data: bytes, done: Done) -> ProcessRequest:
        return self._act(process, lambda one, end: self._signals.send(one, data, end), done)

    def kill(
        self, process: Process, signum: int, done: Done, *, as_crash: bool = False
    ) -> ProcessRequest:
        """Send it this signal, also while it is being stopped; see `ProcessSignals`."""
        kill = functools.partial(self._signals.kill, signum=signum, as_crash=as_crash)
        return self._act(process, lambda one, end: kill(one, done=end), done, is_urgent=True)

    def _act(
        self,
        process: Process,
        do: Callable[[Process, Done], None],
        done: Done,
        *,
        is_urgent: bool = False,
    ) -> ProcessRequest:
        act = functools.partial(do, process)
        return self.ask(process, ProcessRequest(Purpose.ACT, done, act=act, is_urgent=is_urgent))

    def ask(self, process: Process, request: ProcessRequest) -> ProcessRequest:
        """Carry it out when its turn has come; returns it, to `withdraw` it."""
        queue = self._queues.setdefault(process, RequestQueue())
        self._settle(process)
        self._carry_out(process, queue.add(request, self._situation(process)))
        self._settle(process)
        if request.purpose is not Purpose.ACT and queue.holds(request):
            self._note(process, request)
        return request

    def withdraw(self, process: Process, request: ProcessRequest) -> None:
        """Who asked has gone: do not begin with it any more."""
        if process in self._queues:
            self._queues[process].withdraw(request)
            self._settle(process)

    def changed(self) -> None:
        """A process has started, exited or got stuck: go on with requests."""
        if self._signals.is_waiting or any(one.current for one in self._queues.values()):
            self._reactor.call_later(0, self._go_on)

    def _go_on(self) -> None:
        for process in list(self._queues):
            self._settle(process)
        self._signals.check()

    def _settle(self, process: Process) -> None:
        queue = self._queues[process]
        while queue.current and (actions := queue.settle(self._situation(process))):
            self._carry_out(process, actions)

    def _situation(self, process: Process) -> Situation:
        refusal = Kind.RUN_STOPPING if self._shutdown.has_begun else None
        if refusal is None and (lost := unreachable(process)):
            refusal = lost.kind
        return Situation(
            now=self._reactor.now(),
            phase=self._phase(process),
            last_end=process.last_end,
            refusal=refusal,
            is_cut_off=process.host is not None and process.host.unreachable_s is not None,
        )

    def _phase(self, process: Process) -> ProcessPhase:
        if process.machine.is_stuck:
            return ProcessPhase.STUCK
        match process.machine.state:
            case ProcessState.STARTING if process.child is not None:
                return ProcessPhase.STARTING
            case ProcessState.STARTING:
                return ProcessPhase.WAITING if self._driver.waits(process) else ProcessPhase.QUEUED
            case ProcessState.RUNNING:
                return ProcessPhase.RUNNING
            case ProcessState.STOPPING:
                return ProcessPhase.STOPPING
            case ProcessState.BACKOFF:
                return ProcessPhase.BACKOFF
        return ProcessPhase.ENDED

    def _carry_out(self, process: Process, actions: Sequence[QueueAction]) -> None:
        for action in actions:
            match action:
                case Do(order=order, step=step):
                    self._do(process, order, step)
                case Answer(requests=requests, kind=kind, step=step):
                    for request in requests:
                        process.is_replaced = process.is_replaced and not request.is_replacement
                        request.done(self._result(process, request, kind, step))
                case Act(step=step):
                    (request,) = step.requests
                    request.act(functools.partial(self._acted, process, step, request))

    def _acted(
        self, process: Process, step: RequestStep, request: ProcessRequest, result: Result
    ) -> None:
        self._queues[process].finish(step)
        request.done(result)
        self._settle(process)

    def _do(self, process: Process, order: RequestOrder, step: RequestStep) -> None:
        for request in step.requests:
            self._note(process, request)
        match order:
            case RequestOrder.STOP:
                step.old_pid = _pid_of(process)
                process.is_replaced = all(one.is_replacement for one in step.requests)
                self._driver.advance(process, MachineCommand.USER_STOP)
                if step.purpose.starts:
                    self._driver.expect(process)
            case RequestOrder.START:
                self._driver.advance(process, MachineCommand.USER_START)
            case RequestOrder.SKIP_WAIT:
                self._driver.skip_wait(process)
            case RequestOrder.BEGIN_AGAIN:
                self._driver.begin_again(process)

    def _note(self, process: Process, request: ProcessRequest) -> None:
        """Log it, once, when it is being carried out or has to wait."""
        if not request.is_noted:
            request.is_noted = True
            self._log.note(run_events.Asked(request.purpose.name.lower()), process)

    def _result(
        self, process: Process, request: ProcessRequest, kind: Kind, step: RequestStep
    ) -> Result:
        is_stop, is_restart = request.purpose is Purpose.STOP, request.purpose > Purpose.START
        host, stopped = process.host, None
        if is_restart and step.first_end is not None:
            stopped = self._stopped(process, step.stopped_s - request.asked_s, step.first_end)
        result = Result(process.name, kind, done=False, stopped=stopped)
        match kind:
            case Kind.STOPPED:
                elapsed_s = self._reactor.now() - request.asked_s
                is_disabled = may_restart(process)
                stopped = self._stopped(process, elapsed_s, process.last_end)
                return replace(stopped, restart_disabled=is_disabled)
            case Kind.NOT_RUNNING:
                return not_running(process)
            case Kind.STARTED:
                old_pid = step.old_pid if is_restart else None
                return replace(result, done=True, pid=_pid_of(process), old_pid=old_pid)
            case Kind.START_FAILED:
                return replace(result, exit=process.last_end and process.last_end.outcome)
            case Kind.ALREADY_RUNNING:
                return replace(result, pid=_pid_of(process))
            case Kind.START_CANCELLED | Kind.RESTART_CANCELLED | Kind.QUEUED:
                return replace(result, done=is_stop or (is_restart and kind is Kind.QUEUED))
        if host is None:
            return result
        silent_s = 0.0 if host.unreachable_s is None else host.unreachable_s
        is_accepted = kind is Kind.STOP_WAITS
        return replace(result, done=is_accepted, host=host.name, elapsed_s=silent_s)

    def _stopped(self, process: Process, elapsed_s: float, end: ReportExit | None) -> Result:
        return Result(
            process=process.name,
            kind=Kind.STOPPED,
            done=True,
            elapsed_s=elapsed_s,
            signum=process.machine.stop_signal,
            exit=None if end is None else end.outcome,
        )


def _pid_of(process: Process) -> int | None:
    return None if process.child is None else process.child.pid
