"""Carries out the actions of the state machine of each process, and feeds it events."""

from __future__ import annotations

import errno
import functools
import os
import signal
import time

from launcher.base.model import run_events
from launcher.base.model.events import SIGNALLED, Outcome, refusal
from launcher.base.model.run_events import known
from launcher.posix import proc
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import Child
from launcher.run.logs import messages
from launcher.run.logs.run_log import RunLog
from launcher.run.machine import (
    OWN_TIMERS,
    Action,
    Command,
    Ended,
    Escalate,
    Exited,
    MachineEvent,
    Order,
    ProcessState,
    Signal,
    SignalSent,
    SpawnError,
    Stuck,
)
from launcher.run.output.reader import OutputReader
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    from launcher.run.listener import RunListener
    from launcher.run.monitor.oom import OomWatch
    from launcher.run.ready.gate import ReadyGate

    class StartGate(Protocol):
        """Holds starts back: `StartPacing` and `ReadyGate`."""

        def admit(self, process: Process) -> None: ...

        # It shall not start any more; False if it was not held back.
        def withdraw(self, process: Process) -> bool: ...

    class WarmStarts(Protocol):
        """What starts processes warm (`engine.warm`)."""

        # Whether it starts the process, later: it is adopted then, or spawned cold. Give that up;
        # False if no start is under way.
        def admit(self, process: Process) -> bool: ...
        def withdraw(self, process: Process) -> bool: ...

        # Whether such a start is under way; whether it waits for a preparation that is not over.
        def is_starting(self, process: Process) -> bool: ...
        def awaits_preparation(self, process: Process) -> bool: ...


# Of a process that was stopped: 1 is that of an exception, also of rclpy's, and a shell's own are
# those after the signals of a stop.
USUAL_CODES = (0, 1, SIGNALLED + signal.SIGINT, SIGNALLED + signal.SIGTERM)


class ProcessDriver:
    """Spawns, signals, reaps and reports."""

    def __init__(
        self, reactor: Reactor, reader: OutputReader, log: RunLog, listener: RunListener
    ) -> None:
        self._reactor = reactor
        self._reader = reader
        self._log = log
        self._listener = listener
        self._oom: OomWatch | None = None
        self._gate: StartGate | None = None
        self._ready: ReadyGate | None = None
        self.warm: WarmStarts | None = None

    def watch_memory(self) -> None:
        """Read the kernel's counter of OOM kills, before a process can be a victim."""
        from launcher.run.monitor.oom import OomWatch

        self._oom = OomWatch()

    def _was_out_of_memory(self) -> bool:
        return self._oom is not None and self._oom.has_struck()

    def pace(self, *, stagger_s: float, most: int | None) -> None:
        """From now on queue the starts; see `StartPacing`."""
        from launcher.run.start_pacing import StartPacing

        pacing = StartPacing(self._reactor, stagger_s=stagger_s, most=most, start=self._spawn)
        self._gate = pacing

    def order(self, gate: ReadyGate) -> None:
        """From now on first starts wait for other processes, and then for their turn."""
        gate.lead_to(self._gate, self._spawn)
        self._gate = self._ready = gate

    def waits(self, process: Process) -> bool:
        """Whether its start waits until other processes are ready."""
        return self._ready is not None and self._ready.waits(process)

    def skip_wait(self, process: Process) -> None:
        """Start a process that waits for others."""
        if self._ready is not None:
            self._ready.skip(process)

    def begin_again(self, process: Process) -> None:
        """Give up a warm start that is under way, and begin it with what its spec is now."""
        if self.warm is not None and self.warm.withdraw(process):
            self._spawn(process)

    def is_under_way(self, process: Process) -> bool:
        """Whether its start here is being carried out: not held back, and not complete."""
        if process.host is not None or process.machine.state is not ProcessState.STARTING:
            return False
        is_warm = self.warm is not None and self.warm.is_starting(process)
        return is_warm or process.child is not None

    def awaits_preparation(self, process: Process) -> bool:
        """Whether its warm start waits for the preparation, which is not over."""
        return self.warm is not None and self.warm.awaits_preparation(process)

    def advance(self, process: Process, event: MachineEvent) -> None:
        """Feed the state machine, carry out its actions, and set a timer for its deadline."""
        for action in process.machine.handle(event, self._reactor.now()):
            self._do(process, action)
        if process.machine.state is ProcessState.STOPPING and self._withdraw(process):
            self._cancelled(process)
        self._set_timer(process)

    def _do(self, process: Process, action: Action) -> None:
        match action:
            case Order.SPAWN:
                (self._spawn if self._gate is None else self._gate.admit)(process)
            case Signal(signum=signum):
                self._signal(process, signum)
                if action.needs_wake:
                    self._wake(process)
            case Order.WAKE:
                self._wake(process)
            case Escalate():
                by_user = process.machine.is_held
                self._log.report(process, messages.escalated(process.name, action, by_user=by_user))
            case Stuck(waited_s=waited_s):
                self._stuck(process, waited_s)
            case Ended():
                self._ended(process, action)

    def _stuck(self, process: Process, waited_s: float) -> None:
        pid = -1 if process.child is None else process.child.pid
        self._report_stuck(process, pid, waited_s, proc.describe_state(pid))
        self._listener.idle()

    def _report_stuck(
        self, process: Process, pid: int, waited_s: float, how: str, at_s: float | None = None
    ) -> None:
        self._log.report(process, messages.stuck(process.name, pid, waited_s, how))
        sleeps = how if process.host is None else None
        self._log.note(run_events.Stuck(known(pid), sleeps), process, at_s)

    def _withdraw(self, process: Process) -> bool:
        """Give up a start that is held back or queued; False if none is."""
        if self._gate is not None and self._gate.withdraw(process):
            return True
        return self.warm is not None and self.warm.withdraw(process)

    def _cancelled(self, process: Process) -> None:
        self._report_cancelled(process)
        self.advance(process, Command.START_CANCELLED)
        self._listener.cancelled(process)
        self._listener.idle()

    def _report_cancelled(self, process: Process, at_s: float | None = None) -> None:
        self._log.report(process, messages.start_cancelled())
        self._log.note(run_events.Withdrawn(), process, at_s)

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
            self._listener.before_kill()
        self._report_signal(process, process.child.pid, signum)
        process.child.signal_group(signum)

    def _report_signal(
        self, process: Process, pid: int, signum: int, at_s: float | None = None
    ) -> None:
        self._log.report(process, messages.signalled(process.name, signum))
        self._log.note(run_events.Signalled(known(pid), int(signum)), process, at_s)

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
            text = f"cannot write to its standard input: {os.strerror(error.errno or 0)}"
            self._log.report(process, messages.Line("WARNING", text))

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
        self.advance(process, Command.TICK)
        self._listener.idle()

    def _spawn(self, process: Process) -> None:
        process.begun_wall_s = time.time()
        if self.warm is None or not self.warm.admit(process):
            self.spawn_cold(process)

    def spawn_cold(self, process: Process) -> None:
        """Execute its program."""
        try:
            child = self._listener.spawn(process)
        except OSError as error:
            self._refused(process, error.errno or errno.EIO, _culprit(process, error))
            return
        self.adopt(process, child)

    def adopt(self, process: Process, child: Child) -> None:
        """It has this child from now on, which runs, or tells by its `status` when it does."""
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
        self._report_refusal(process, number, what)
        self.advance(process, SpawnError(number, what))

    def _report_refusal(
        self, process: Process, number: int, what: str, at_s: float | None = None
    ) -> None:
        self._log.report(process, messages.not_started(process, number, what))
        self._log.note(run_events.NotStarted(refusal(number, what)), process, at_s)

    def _limits_applied(self, process: Process, child: Child) -> None:
        """A process with limits has exec'd its program, or exits since a limit was refused."""
        self._reactor.remove(child.status)
        child.read_refusal()
        if not child.refusal:
            self._runs(process, child)

    def _runs(self, process: Process, child: Child) -> None:
        self._report_start(process, child.pid)
        self.advance(process, Command.STARTED)
        self._listener.started(process, child.pid)

    def _report_start(self, process: Process, pid: int, at_s: float | None = None) -> None:
        self._log.report(process, messages.started(pid, process.host_name))
        facts = tuple(self._listener.awaited_facts(process))
        started = run_events.Started(pid, process.machine.restarts, facts)
        self._log.note(started, process, at_s)
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
            self._listener.idle()
            return
        was_killed = returncode == -signal.SIGKILL
        outcome = Outcome(
            returncode=returncode,
            core_dumped=core_dumped,
            out_of_memory=was_killed and self._was_out_of_memory(),
        )
        self.advance(process, Exited(outcome))
        if leaves_nothing:
            self._listener.may_have_left(process, child.pid)
        self._listener.idle()

    def _ended(self, process: Process, end: Ended, at_s: float | None = None) -> None:
        """It exited `at_s`, on the monotonic clock; None: just now."""
        pid = -1 if process.child is None else process.child.pid
        now = self._reactor.now()
        ago_s = 0.0 if at_s is None else now - at_s
        process.last_end, process.ended_wall_s = end, time.time() - ago_s
        self._add_to_history(process, end, now - ago_s)
        if process.silence is not None:
            self._report_hang(process, now)
        returncode = end.outcome.returncode
        if returncode is not None:
            by_user = process.machine.is_held
            self._log.report(process, messages.ended(process, pid, end, by_user=by_user))
            ended = run_events.Ended(known(pid), returncode, end.asked, end.retry_in_s)
            self._log.note(ended, process, at_s)
            self._report_core(process, pid, end)
        self._report_restart(process, end)
        for dropped in self._reader.keep(process):
            self._log.log("WARNING", "launch", messages.no_longer_read(dropped.name))
        self._release(process)
        self._listener.ended(process, pid, end)

    def _report_hang(self, process: Process, now: float) -> None:
        """It has ended while its node did not answer: keep its stack for the summary."""
        silence, process.silence = process.silence, None
        assert silence is not None
        text = f"had not responded for {silence.elapsed_s(now):.0f} s before it ended"
        process.history.hang = (f"{process.name} {text}; its stack:", *silence.stack)
        stack = "".join(f"\n    {line}" for line in silence.stack)
        self._log.log("WARNING", process.name, f"{text}; its stack:{stack}", sink="log")

    def _report_core(self, process: Process, pid: int, end: Ended) -> None:
        """Name the core file after a death by a signal; how to get one is told once."""
        code = end.outcome.returncode or 0
        if end.asked or process.host is not None or 0 <= code <= SIGNALLED:
            return
        from launcher.run.logs import core_file

        note = core_file.note_of(process, pid, end.outcome)
        has_core = end.outcome.core_dumped or code > 0
        if note and (has_core or process.history.core_note != note):
            self._log.report(process, messages.Line("ERROR" if has_core else "INFO", note))
        process.history.core_note = note

    def _add_to_history(self, process: Process, end: Ended, at_s: float) -> None:
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

    def _report_restart(self, process: Process, end: Ended) -> None:
        machine = process.machine
        if end.retry_in_s:
            line = messages.restarts_in(
                end.retry_in_s, machine.restarts, machine.restart.max_restarts
            )
            self._log.report(process, line)
        if machine.has_used_up_restarts:
            self._log.report(process, messages.restarts_used_up(machine))


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
