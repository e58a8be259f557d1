"""Keeper: does what the machine of each process says, and tells the machine what happened."""

from __future__ import annotations

import errno
import functools
import os
import signal
import time
from collections.abc import Callable

from launcher.engine import report
from launcher.engine.chronicle import Chronicle
from launcher.engine.machine import (
    POLITE,
    Action,
    Ended,
    Escalate,
    Exited,
    MachineEvent,
    Outcome,
    ProcessState,
    Sent,
    Signal,
    Spawn,
    SpawnError,
    Started,
    Stuck,
    Tick,
    Withdrawn,
)
from launcher.engine.process import Process
from launcher.engine.reactor import Reactor
from launcher.engine.relay import Relay
from launcher.engine.spawn import Child
from launcher.model.events import Event, ProcessExited, ProcessStarted, SpawnFailed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.engine.oom import OomWatch
    from launcher.engine.pacing import Pacer


class Keeper:
    """Spawns, signals, reaps and reports.

    `start_child(process)` spawns (OSError); `on_event` gets what the interpreter has to know;
    `on_end(process, end)` is called after each end has been reported, `on_idle()` when something
    has ended or a waiting time is over and nothing else follows from it, `before_kill()` before a
    process that does not go is killed, `on_left(process, pid)` when one has ended whose group is
    not to outlive it.
    """

    def __init__(
        self,
        reactor: Reactor,
        relay: Relay,
        chronicle: Chronicle,
        *,
        start_child: Callable[[Process], Child],
        on_event: Callable[[Event], None],
        on_end: Callable[[Process, Ended], None],
        on_idle: Callable[[], None],
        before_kill: Callable[[], None],
        on_left: Callable[[Process, int], None],
    ) -> None:
        self._reactor = reactor
        self._relay = relay
        self._chronicle = chronicle
        self._start_child = start_child
        self._on_event = on_event
        self._on_end = on_end
        self._on_idle = on_idle
        self._before_kill = before_kill
        self._on_left = on_left
        self._oom: OomWatch | None = None
        self._pacer: Pacer | None = None
        self.has_killed = False

    def watch_memory(self) -> None:
        """Look at the kernel's counter, before anything that runs can be killed for it."""
        from launcher.engine.oom import OomWatch

        self._oom = OomWatch()

    def _was_out_of_memory(self) -> bool:
        return self._oom is not None and self._oom.has_struck()

    def note_kill(self) -> None:
        """Something of the run had to be killed, which counts for the exit code."""
        self.has_killed = True

    def pace(self, *, stagger_s: float, most: int | None) -> None:
        """From now on let processes start one after the other, as `Pacer` has it."""
        from launcher.engine.pacing import Pacer

        self._pacer = Pacer(self._reactor, stagger_s=stagger_s, most=most, start=self._spawn)

    def advance(self, process: Process, event: MachineEvent) -> None:
        """Feed the machine, do what it says, and wake it at its deadline."""
        for action in process.machine.handle(event, self._reactor.now()):
            self._do(process, action)
        if self._pacer is not None and process.machine.state is ProcessState.STOPPING:
            self._withdraw(process, self._pacer)
        self._set_timer(process)

    def _do(self, process: Process, action: Action) -> None:
        match action:
            case Spawn():
                (self._spawn if self._pacer is None else self._pacer.admit)(process)
            case Signal(signum=signum):
                if signum == signal.SIGKILL:
                    self._before_kill()
                self.signal(process, signum)
                self._wake(process, signum)
            case Escalate(to=to):
                by_hand = process.held  # a person asked for it: the run has not failed
                self.has_killed |= to == signal.SIGKILL and not by_hand
                self._chronicle.tell(
                    process, report.escalated(process.name, action, by_hand=by_hand)
                )
            case Stuck():
                self._stuck(process, action)
            case Ended():
                self._ended(process, action)

    def _stuck(self, process: Process, stuck: Stuck) -> None:
        from launcher.engine.sleepers import how_it_sleeps

        pid = -1 if process.child is None else process.child.pid
        how = how_it_sleeps(pid)
        self.has_killed = True
        self._chronicle.tell(process, report.stuck(process.name, pid, stuck.waited_s, how))
        self._chronicle.note("stuck", process, pid=pid, sleeps=how)
        self._on_idle()

    def _withdraw(self, process: Process, pacer: Pacer) -> None:
        """A stop has come before its turn to start."""
        if pacer.withdraw(process):
            self._chronicle.tell(process, report.withdrawn())
            self._chronicle.note("withdrawn", process)
            self.advance(process, Withdrawn())
            if not process.held:
                self._on_event(_spawn_failed(process, errno.ECANCELED, will_restart=False))
            self._on_idle()

    def signal(self, process: Process, signum: int) -> None:
        """Send a signal to the group of a process, if it lives."""
        if process.child is None:
            return
        self._chronicle.tell(process, report.signalled(process.name, signum))
        self._chronicle.note("signal", process, pid=process.child.pid, signal=int(signum))
        process.child.signal_group(signum)
        if process.paused:
            self._wake(process, signum)

    def _wake(self, process: Process, signum: int) -> None:
        """What stands still, whoever stopped it, would notice nothing but SIGKILL.

        The others in the group hear nothing of it, unless they have a handler for SIGCONT.
        """
        if process.child is not None and signum in POLITE:
            process.child.signal_group(signal.SIGCONT)
            process.paused = False

    def send(self, process: Process, signum: int) -> None:
        """Send a signal because a person wants it: an end by it is asked and not repeated."""
        if signum == signal.SIGKILL:
            self._before_kill()
        process.machine.handle(Sent(signum), self._reactor.now())
        self.signal(process, signum)

    def write_stdin(self, process: Process, data: bytes) -> None:
        """Hand data to the standard input of a process, if it lives and reads."""
        if process.child is None:
            return
        try:
            process.child.write_stdin(data)
        except OSError as error:
            text = f"standard input takes nothing: {os.strerror(error.errno or 0)}"
            self._chronicle.tell(process, report.Line("WARNING", text))

    def let_go(self, process: Process) -> None:
        """Forget the child and close what belongs to it."""
        if process.child is not None:
            self._relay.detach(process)
            self._reactor.remove(process.child.pidfd)
            if process.child.status >= 0:
                self._reactor.remove(process.child.status)
            process.child.close()
            process.child = None
            process.paused = False

    def _set_timer(self, process: Process) -> None:
        if process.timer is not None:
            process.timer.cancel()
            process.timer = None
        deadline = process.machine.deadline
        if deadline is not None:
            tick = functools.partial(self._tick, process)
            process.timer = self._reactor.call_later(deadline - self._reactor.now(), tick)

    def _tick(self, process: Process) -> None:
        self.advance(process, Tick())
        self._on_idle()

    def _spawn(self, process: Process) -> None:
        try:
            child = process.child = self._start_child(process)
        except OSError as error:
            self._refused(process, error.errno or errno.EIO, _culprit(process, error))
            return
        self._relay.attach(process)
        self._reactor.add_reader(child.pidfd, functools.partial(self._exited, process))
        if child.status < 0:
            self._runs(process, child)
        else:
            left = functools.partial(self._left_stage, process, child)
            self._reactor.add_reader(child.status, left)

    def _refused(self, process: Process, number: int, what: str) -> None:
        self._chronicle.tell(process, report.not_started(process.spec, number, what))
        reason = f"{what}: {os.strerror(number)}" if what else os.strerror(number)
        self._chronicle.note("not started", process, reason=reason)
        self.advance(process, SpawnError(number, what))

    def _left_stage(self, process: Process, child: Child) -> None:
        """A process with limits has become its program, or is going to end because it cannot."""
        self._reactor.remove(child.status)
        child.leave_stage()
        if not child.refusal:
            self._runs(process, child)

    def _runs(self, process: Process, child: Child) -> None:
        self._chronicle.tell(process, report.started(child.pid))
        restarts = process.machine.restarts
        self._chronicle.note("started", process, pid=child.pid, restarts=restarts)
        self.advance(process, Started(child.pid))
        self._on_event(ProcessStarted(process_id=process.process_id, pid=child.pid))

    def _exited(self, process: Process) -> None:
        child = process.child
        assert child is not None
        if child.status >= 0:
            self._left_stage(process, child)
        machine = process.machine
        leaves_nothing = machine.state is ProcessState.STOPPING
        if machine.may_restart or process.held:
            leaves_nothing = True
            # What it leaves in its group would run beside its successor. The group is safe to
            # signal only now, while the leader is not reaped and its number cannot be given away.
            child.signal_group(signal.SIGTERM)
        returncode, core_dumped = child.reap()
        self._relay.drain(process)
        if child.refusal:
            from launcher.engine.staging import refusal

            self._refused(process, *refusal(child.refusal))
            self._on_idle()
            return
        was_killed = returncode == -signal.SIGKILL
        outcome = Outcome(
            returncode=returncode,
            core_dumped=core_dumped,
            out_of_memory=was_killed and self._was_out_of_memory(),
        )
        self.advance(process, Exited(outcome))
        if leaves_nothing:
            self._on_left(process, child.pid)
        self._on_idle()

    def _ended(self, process: Process, end: Ended) -> None:
        pid = -1 if process.child is None else process.child.pid
        process.last_end, process.ended_wall_s = end, time.time()
        by_hand = process.held
        process.held = process.held or end.sent
        returncode = end.outcome.returncode
        if returncode is not None:
            self._chronicle.tell(process, report.ended(process.spec, pid, end, by_hand=by_hand))
            self._chronicle.note(
                "ended",
                process,
                pid=pid,
                returncode=returncode,
                asked=end.asked,
                restart_in_s=end.retry_in_s,
            )
        self._tell_what_follows(process, end)
        self.let_go(process)
        self._on_end(process, end)
        self._on_event(_event_of(process, pid, end))

    def _tell_what_follows(self, process: Process, end: Ended) -> None:
        machine = process.machine
        if end.retry_in_s:
            line = report.restarts_in(
                end.retry_in_s, machine.restarts, machine.restart.max_restarts
            )
            self._chronicle.tell(process, line)
        if machine.state is ProcessState.FATAL and machine.restarts:
            self._chronicle.tell(process, report.gave_up(machine.restart, machine.restarts))


def _culprit(process: Process, error: OSError) -> str:
    """What was wrong where it is not the program, or "" where it is."""
    cwd = process.spec.cwd
    if cwd is not None and not os.path.isdir(cwd):
        return f"working directory '{cwd}'"
    is_ordinary = error.errno is None or error.strerror == os.strerror(error.errno)
    return "" if is_ordinary else str(error.strerror)


def _event_of(process: Process, pid: int, end: Ended) -> Event:
    outcome = end.outcome
    will_restart = end.retry_in_s is not None or process.held
    if outcome.returncode is None:
        return _spawn_failed(process, outcome.spawn_errno or errno.EIO, will_restart=will_restart)
    return ProcessExited(
        process_id=process.process_id,
        pid=pid,
        returncode=outcome.returncode,
        will_restart=will_restart,
    )


def _spawn_failed(process: Process, number: int, *, will_restart: bool) -> Event:
    return SpawnFailed(
        process_id=process.process_id,
        errno=number,
        reason=os.strerror(number),
        will_restart=will_restart,
    )
