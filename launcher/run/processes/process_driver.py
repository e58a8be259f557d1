"""Carries out the actions of the state machine of each process, and feeds it events."""

from __future__ import annotations

import errno
import functools
import os
import signal
import time

from launcher.base.model.events import SIGNALLED, Outcome
from launcher.posix import proc
from launcher.posix.spawn import Child
from launcher.run.processes.machine import OWN_TIMERS
from launcher.run.processes.machine_events import (
    Action,
    Escalate,
    Exited,
    MachineAction,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
    ReportStuck,
    Signal,
    SignalSent,
    SpawnError,
)
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

    from launcher.run.driven_run import DrivenRun
    from launcher.run.monitor.oom import OomWatch
    from launcher.run.part import StartStage
    from launcher.run.processes.process_reports import ProcessReports

# Of a process that was stopped: 1 is that of an exception, also of rclpy's, and a shell's own are
# those after the signals of a stop.
USUAL_CODES = (0, 1, SIGNALLED + signal.SIGINT, SIGNALLED + signal.SIGTERM)


class ProcessDriver:
    """Spawns, signals, reaps and reports."""

    def __init__(self, run: DrivenRun) -> None:
        self._run = run
        self._reactor = run.reactor
        self._reader = run.reader
        self._oom: OomWatch | None = None

    @functools.cached_property
    def _reports(self) -> ProcessReports:
        from launcher.run.processes.process_reports import ProcessReports

        return ProcessReports(self._run.log)

    def watch_memory(self) -> None:
        """Read the kernel's counter of OOM kills, before a process can be a victim."""
        from launcher.run.monitor.oom import OomWatch

        self._oom = OomWatch()

    def _was_out_of_memory(self) -> bool:
        return self._oom is not None and self._oom.has_struck()

    @property
    def _stages(self) -> Sequence[StartStage]:
        return self._run.stages

    def pass_on(self, process: Process, stage: StartStage | None = None) -> None:
        """A start goes on behind this stage, or to the first one; the last leads to its program."""
        after = 0 if stage is None else self._stages.index(stage) + 1
        if after < len(self._stages):
            self._stages[after].admit(process)
        else:
            self.spawn(process)

    def waits(self, process: Process) -> bool:
        """Whether its start waits until other processes are ready."""
        return any(stage.waits(process) for stage in self._stages)

    def skip_wait(self, process: Process) -> None:
        """Start a process that waits for others."""
        for stage in self._stages:
            stage.skip(process)

    def expect(self, process: Process) -> None:
        """A process that is being stopped will be started when it has ended."""
        for stage in self._stages:
            stage.expect(process)

    def begin_again(self, process: Process) -> None:
        """Give up a start that a stage is carrying out, and begin it with what its spec is now."""
        for stage in self._stages:
            if stage.is_starting(process) and stage.withdraw(process):
                stage.admit(process)

    def is_under_way(self, process: Process) -> bool:
        """Whether its start here is being carried out: not held back, and not complete."""
        if process.host is not None or process.machine.state is not ProcessState.STARTING:
            return False
        return process.child is not None or any(one.is_starting(process) for one in self._stages)

    def awaits_preparation(self, process: Process) -> bool:
        """Whether its start waits for a preparation, which is not over."""
        return any(stage.awaits_preparation(process) for stage in self._stages)

    def advance(self, process: Process, event: MachineEvent) -> None:
        """Feed the state machine, carry out its actions, and set a timer for its deadline."""
        for action in process.machine.handle(event, self._reactor.now()):
            self._do(process, action)
        if process.machine.state is ProcessState.STOPPING and self._withdraw(process):
            self._cancelled(process)
        self._set_timer(process)

    def _do(self, process: Process, action: Action) -> None:
        match action:
            case MachineAction.SPAWN:
                self.pass_on(process)
            case Signal(signum=signum):
                self._signal(process, signum)
                if action.needs_wake:
                    self._wake(process)
            case MachineAction.WAKE:
                self._wake(process)
            case Escalate():
                self._reports.escalated(process, action)
            case ReportStuck(waited_s=waited_s):
                self._stuck(process, waited_s)
            case ReportExit():
                self._ended(process, action)

    def _stuck(self, process: Process, waited_s: float) -> None:
        pid = -1 if process.child is None else process.child.pid
        self._reports.stuck(process, pid, waited_s, proc.describe_state(pid))
        self._run.idle()

    def _withdraw(self, process: Process) -> bool:
        """Give up a start that is held back or queued; False if none is."""
        return any(stage.withdraw(process) for stage in self._stages)

    def _cancelled(self, process: Process) -> None:
        self._reports.cancelled(process)
        self.advance(process, MachineCommand.START_CANCELLED)
        self._run.cancelled(process)
        self._run.idle()

    def signal(self, process: Process, signum: int, *, by_user: bool = False) -> None:
        """Send a signal to the group of a process, if it is running.

        An exit by a signal `by_user` counts as requested, and is not followed by a restart.
        """
        if process.child is not None:
            self._signal(process, signum)
            self.advance(process, SignalSent(signum, by_user=by_user))

    def _signal(self, process: Process, signum: int) -> None:
        if process.child is None:
            return
        if signum == signal.SIGKILL:
            self._run.before_kill()
        self._reports.signalled(process, process.child.pid, signum)
        process.child.signal_group(signum)

    def _wake(self, process: Process) -> None:
        if process.child is not None:
            process.child.signal_group(signal.SIGCONT)

    def write_stdin(self, process: Process, data: bytes) -> None:
        """Write to the standard input of a process, if it is running; warn if it does not read."""
        if process.child is None:
            return
        try:
            process.child.write_stdin(data)
        except OSError as error:
            self._reports.unread_input(process, error)

    def read_rest(self, process: Process) -> None:
        """Read what the descendants that have outlived it have written before they ended."""
        self._reader.drain(process)

    def release(self, process: Process) -> None:
        """Close the child and its descriptors, and those of earlier ones that were kept."""
        self._reader.detach(process)
        self._release(process)

    def _release(self, process: Process) -> None:
        if process.child is not None:
            self._reactor.remove(process.child.pidfd)
            if process.child.status >= 0:
                self._reactor.remove(process.child.status)
            process.child.close()
            process.child = process.debugger = None
            process.answers = False

    def _set_timer(self, process: Process) -> None:
        if process.timer is not None:
            process.timer.cancel()
            process.timer = None
        deadline = process.machine.deadline
        if deadline is not None:
            tick = functools.partial(self._tick, process)
            process.timer = self._reactor.call_later(deadline - self._reactor.now(), tick)

    def _tick(self, process: Process) -> None:
        self.advance(process, MachineCommand.TICK)
        self._run.idle()

    def spawn(self, process: Process) -> None:
        """Execute its program."""
        process.begun_wall_s = time.time()
        try:
            child = self._run.spawner.spawn(process)
        except OSError as error:
            self._refused(process, error.errno or errno.EIO, _culprit(process, error))
            return
        self.adopt(process, child)

    def adopt(self, process: Process, child: Child) -> None:
        """It has this child from now on, which runs, or reports by its `status` when it does."""
        process.child = child
        self._reader.attach(process)
        self._reactor.add_reader(child.pidfd, functools.partial(self._exited, process))
        if child.status < 0:
            self._runs(process, child)
        else:
            left = functools.partial(self._limits_applied, process, child)
            self._reactor.add_reader(child.status, left)

    def refuse(self, process: Process, number: int, what: str) -> None:
        """A start that was held back fails."""
        self._refused(process, number, what)

    def _refused(self, process: Process, number: int, what: str) -> None:
        self._reports.refused(process, number, what)
        self.advance(process, SpawnError(number, what))

    def _limits_applied(self, process: Process, child: Child) -> None:
        """A process with limits has exec'd its program, or exits since a limit was refused."""
        self._reactor.remove(child.status)
        child.read_refusal()
        if not child.refusal:
            self._runs(process, child)

    def _runs(self, process: Process, child: Child) -> None:
        self._count_start(process, child.pid)
        self.advance(process, MachineCommand.STARTED)
        self._run.started(process, child.pid)

    def _count_start(self, process: Process, pid: int, at_s: float | None = None) -> None:
        self._reports.started(process, pid, at_s)
        process.history.starts += 1

    def _exited(self, process: Process) -> None:
        child = process.child
        assert child is not None
        if child.status >= 0:
            self._limits_applied(process, child)
        machine = process.machine
        leaves_nothing = machine.state is ProcessState.STOPPING
        if machine.may_restart or machine.is_held:
            leaves_nothing = True
            # Leftovers in its group would run beside its successor. The group is safe to signal
            # only now: the pid cannot be reused until the leader is reaped.
            child.signal_group(signal.SIGTERM)
        returncode, core_dumped = child.reap()
        self._reader.drain(process)
        if child.refusal:
            from launcher.posix.limits import parse_refusal

            self._refused(process, *parse_refusal(child.refusal))
            self._run.idle()
            return
        was_killed = returncode == -signal.SIGKILL
        outcome = Outcome(
            returncode=returncode,
            core_dumped=core_dumped,
            out_of_memory=was_killed and self._was_out_of_memory(),
        )
        self.advance(process, Exited(outcome))
        if leaves_nothing:
            self._run.may_have_left(process, child.pid)
        self._run.idle()

    def _ended(self, process: Process, end: ReportExit, at_s: float | None = None) -> None:
        """It exited `at_s`, on the monotonic clock; None: just now."""
        pid = -1 if process.child is None else process.child.pid
        now = self._reactor.now()
        ago_s = 0.0 if at_s is None else now - at_s
        process.last_end, process.ended_wall_s = end, time.time() - ago_s
        self._add_to_history(process, end, now - ago_s)
        if process.silence is not None:
            self._reports.hung(process, now)
        self._reports.ended(process, pid, end, at_s)
        self._reports.restart(process, end)
        for dropped in self._reader.keep(process):
            self._reports.no_longer_read(dropped.name)
        self._release(process)
        self._run.ended(process, pid, end)

    def _add_to_history(self, process: Process, end: ReportExit, at_s: float) -> None:
        history = process.history
        began_s = process.machine.running_since
        code = end.outcome.returncode
        if code is None:
            history.refusals += not end.asked
            return
        began_s = at_s if began_s is None else began_s  # it has ended before its program began
        history.run_s += at_s - began_s
        if end.asked:
            if code not in USUAL_CODES and (code > 0 or -code in OWN_TIMERS):
                history.odd_code = history.odd_code or code
            return
        if not end.outcome.failed:
            history.exits += end.retry_in_s is not None
            return
        history.deaths += 1
        history.first_death = history.first_death or end.outcome
        if not history.first_error:  # its restart does not wait for the search
            self._reactor.when_idle(functools.partial(_find_first_error, process, began_s))


def _find_first_error(process: Process, since_s: float) -> None:
    from launcher.run.logs.summary import first_error

    process.history.first_error = process.history.first_error or first_error(process, since_s)


def _culprit(process: Process, error: OSError) -> str:
    """What caused the error; empty if it is the program."""
    cwd = process.spec.cwd
    if cwd is not None and not os.path.isdir(cwd):
        return f"working directory '{cwd}'"
    is_ordinary = error.errno is None or error.strerror == os.strerror(error.errno)
    return "" if is_ordinary else str(error.strerror)
