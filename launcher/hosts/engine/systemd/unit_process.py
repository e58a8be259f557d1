"""A process that is a unit on a host: the state machine of its host, which systemd carries out.

Systemd restarts it; the machine here follows what the journal says. Starts, stops and the signals
of a stop are requested from here. What is in the journal twice, or out of order with the answers
of the shell, counts once: each start has an invocation id.
"""

from __future__ import annotations

import errno
import functools
import signal
import uuid
from collections import deque
from collections.abc import Callable, Mapping

from launcher.base.model.events import Outcome, signal_name
from launcher.hosts.engine.replica import ReportingMachine
from launcher.hosts.engine.systemd.exits import outcome_of_unit, why_not_started
from launcher.hosts.engine.systemd.recent_output import RecentOutput
from launcher.hosts.engine.systemd.scripts import Scripts, read_properties
from launcher.hosts.engine.systemd.shell import ScriptRequest, ScriptResult
from launcher.hosts.engine.systemd.unit_check import Doubt
from launcher.hosts.engine.systemd.unit_state import is_running, state_of, was_stopped
from launcher.hosts.engine.timers import Timers
from launcher.hosts.file import order as orders
from launcher.posix.reactor import Reactor
from launcher.run.processes.machine_events import (
    Action,
    Exited,
    MachineAction,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
    Signal,
    SignalSent,
    SpawnError,
)

# Output that the journal gets from another stream than the record of the exit comes within it.
DRAIN_S = 0.05
_KILLED = -9
_KEPT = 16  # invocations: only the last ones may be reported twice
_STOPS = (MachineCommand.STOP, MachineCommand.USER_STOP)


class UnitProcess:
    """`report(event, at, pid, left)` is called with what its machine has handled.

    `mark` calls back when all that the journal has now has come, or it is silent. `scripts` may
    change when the host was restarted. Call its methods only while the host can be reached, except
    `noted...`.
    """

    def __init__(
        self,
        process_id: int,
        order: orders.Order,
        scripts: Callable[[], Scripts],
        reactor: Reactor,
        request: Callable[[ScriptRequest], None],
        report: Callable[[int, MachineEvent, float, int, float | None], None],
        mark: Callable[[Callable[[], None]], None],
        warn: Callable[[str], None],
    ) -> None:
        self._warn = warn
        self._mark = mark
        self._recent = RecentOutput()
        self.process_id = process_id
        self.order = order
        self._scripts = scripts
        self._reactor = reactor
        self._request = request
        self._report = report
        self.machine = ReportingMachine(order.restart, order.stop, self._handled)
        self.pid = -1
        self._invocations: deque[str] = deque(maxlen=_KEPT)  # whose start was handled
        self._exits: deque[str] = deque(maxlen=_KEPT)  # whose exit was handled
        self._invocation = ""
        self._pending: tuple[Outcome, float] | None = None
        self._is_starting = False  # a start is requested and not answered
        self._starts_itself = False  # systemd does what the machine asks for
        self._is_held = False
        self._is_stopped = False  # its stop was requested from here, since its last start
        self._stopped_s = float("-inf")  # a start that was before is of a unit that is stopped
        self._doubt = Doubt(mark)
        self._last_s = 0.0
        self._is_suspended = False  # unreachable, or its past events are being read
        self._timers = Timers(reactor)

    def _handled(self, event: MachineEvent, at_s: float, left_s: float | None) -> None:
        self._report(self.process_id, event, at_s, self.pid, left_s)

    # ---- the operator

    def command(self, command: MachineCommand) -> None:
        self._flush()
        now = self._reactor.now()
        waits = command in _STOPS and self._waits_for_systemd
        self._handle(command, now)
        if waits:
            if self.machine.state is ProcessState.STOPPING:
                self._handle(MachineCommand.START_CANCELLED, now)
            self._stop()

    @property
    def _waits_for_systemd(self) -> bool:
        """Whether systemd starts it by itself, unless the unit is stopped."""
        if self.machine.state is ProcessState.STARTING:
            return not self._is_starting
        return self.restarts_by_itself

    def _stop(self) -> None:
        """Have systemd stop the unit.

        It may have started the process before that, and the journal shows it later.
        """
        self._is_stopped = True
        self._stopped_s = float("inf")
        self._request(ScriptRequest(self._scripts().stop(self.order.name), self._stop_answered))

    def _stop_answered(self, answer: ScriptResult) -> None:
        if self._is_stopped:
            self._stopped_s = self._reactor.now()

    def signal(self, signum: int, *, by_user: bool) -> None:
        """Send a signal of a user, or of the launch file."""
        if not self.machine.state.is_alive:
            return
        may_end = signum not in (signal.SIGCONT, signal.SIGSTOP)
        if by_user and may_end and self.machine.may_restart:
            # Systemd would restart it.
            self._is_held = True
            self._request(ScriptRequest(self._scripts().hold(self.process_id)))
            self._timers.after("hold", self.order.stop.grace_s + 1.0, self._release)
        name = signal_name(signum)
        text = f"{self.order.name}: {name} may not have arrived: the link was lost meanwhile"
        self._send(signum, functools.partial(self._warn, text))
        # Before the answer, since the journal may show the end of the process first.
        self._handle(SignalSent(signum, by_user=by_user), self._reactor.now())

    def _release(self) -> None:
        """It has survived the signal."""
        if self.machine.state is ProcessState.RUNNING and self._is_held:
            self._is_held = False
            self._request(ScriptRequest(self._scripts().release(self.process_id)))

    # ---- the machine

    def _handle(self, event: MachineEvent, at_s: float) -> None:
        self._last_s = at_s = max(at_s, self._last_s)
        for action in self.machine.handle(event, at_s):
            self._do(action)
        self._set_timer()

    def _by_itself(self, event: MachineEvent, at_s: float) -> None:
        """Systemd has done it; it needs nothing from here."""
        self._starts_itself = True
        self._handle(event, at_s)
        self._starts_itself = False

    def _do(self, action: Action) -> None:
        match action:
            case MachineAction.SPAWN if not self._starts_itself:
                self._start()
            case Signal(signum=signum) if not self._starts_itself:
                if self._is_stopped or _is_pause(signum):
                    self._send(signum)
                else:
                    self._stop()  # it sends the first signal, and continues a suspended process
            case MachineAction.WAKE:
                self._send(signal.SIGCONT)
            case ReportExit():
                self._ended(action)

    def _ended(self, end: ReportExit) -> None:
        self.pid = -1
        self._timers.cancel("hold")

    @property
    def restarts_by_itself(self) -> bool:
        """Whether systemd restarts it after the exit that the machine has handled last."""
        return self.machine.state is ProcessState.BACKOFF and not self._is_own

    _is_own = False  # the restart is requested from here

    def _start(self) -> None:
        self._is_starting = True
        self._is_held = self._is_stopped = False
        self._stopped_s = float("-inf")
        script = self._scripts().start(self.process_id, self.order, uuid.uuid4().hex)
        self._request(ScriptRequest(script, self._start_answered))

    def _start_answered(self, answer: ScriptResult) -> None:
        self._is_starting = False
        if self.machine.state not in (ProcessState.STARTING, ProcessState.STOPPING):
            return  # the journal was faster
        now = self._reactor.now()
        if answer.code:
            self._handle(why_not_started(answer.text, self.order), now)
            return
        found = (read_properties(answer.text) or [{}])[-1]
        invocation, pid = found.get("InvocationID", ""), int(found.get("ExecMainPID") or 0)
        # After a restart that was faster than the answer, the journal has all that happened.
        if found.get("ActiveState") == "active" and found.get("NRestarts") == "0" and pid:
            self.noted_start(invocation, pid, now)

    def _send(self, signum: int, on_loss: Callable[[], None] | None = None) -> None:
        script = self._scripts().signal(self.order.name, signum)
        self._request(ScriptRequest(script, lasts=False, on_loss=on_loss))

    # ---- the journal

    def noted_start(self, invocation: str, pid: int, at_s: float) -> None:
        if invocation in self._invocations:
            return
        self._flush()
        state, was_held = self.machine.state, self.machine.is_held
        if state is ProcessState.RUNNING:  # its exit was not reported
            self._exit(Outcome(returncode=_KILLED), at_s)
            state = self.machine.state
        if state is ProcessState.BACKOFF:
            self.noted_restart(at_s)
        elif not state.is_alive:
            self._by_itself(MachineCommand.USER_START, at_s)  # by another operator
        self._invocations.append(invocation)
        self._invocation, self.pid = invocation, pid
        self._is_stopped = self._is_stopped and at_s <= self._stopped_s
        self._handle(MachineCommand.STARTED, at_s)
        if at_s <= self._stopped_s and self.machine.state is ProcessState.RUNNING:
            self._by_itself(MachineCommand.USER_STOP if was_held else MachineCommand.STOP, at_s)

    def noted_exit(
        self, invocation: str, outcome: Outcome, at_s: float, *, timed_out: bool = False
    ) -> None:
        """`timed_out`: systemd has killed it, since it did not stop in time."""
        if invocation in self._exits:
            return
        if invocation not in self._invocations:
            # A stop may have come before its record.
            self.noted_start(
                invocation, 0, min(at_s, self._stopped_s) if self._is_stopped else at_s
            )
        self._exits.append(invocation)
        while timed_out and self.machine.next_signal is not None:
            self._by_itself(MachineCommand.SKIP_GRACE, at_s)
        self._pending = outcome, at_s
        self._timers.cancel("deadline")
        self._recent.ended()
        self._timers.after("drain", DRAIN_S, self._drain_output)

    def wrote(self, size: int) -> None:
        """So many bytes of output have come."""
        self._recent.add(size)

    def _drain_output(self) -> None:
        """Handle the exit when nothing of its output can be left.

        The journal reads a piece of each stream in turn, so that our record of the exit overtakes
        what is left in the stream of a process that has written much.
        """
        if self._pending is None:
            return
        if not self._recent.may_be_behind:
            self._flush()
            return
        self._recent.looked()
        self._mark(self._drain_output)

    def _flush(self) -> None:
        """Handle the exit: what it has written has come."""
        self._timers.cancel("drain")
        if self._pending is not None:
            (outcome, at_s), self._pending = self._pending, None
            self._exit(outcome, at_s)

    def _exit(self, outcome: Outcome, at_s: float) -> None:
        was_stopping = self.machine.state is ProcessState.STOPPING
        self._is_own = was_stopping or self._is_held
        self._handle(Exited(outcome), at_s)
        if self._is_held and not self.machine.is_pending:
            self._stop()  # before its restart

    def noted_stop(self, at_s: float, *, by_user: bool) -> None:
        """Somebody there, or the watch, stops the unit."""
        self._stopped_s = max(self._stopped_s, at_s)
        if self.machine.state in (ProcessState.RUNNING, ProcessState.BACKOFF):
            self._is_stopped = True
            self._by_itself(MachineCommand.USER_STOP if by_user else MachineCommand.STOP, at_s)

    def noted_restart(self, at_s: float) -> None:
        """Systemd restarts it now."""
        self._flush()
        if self.machine.state is ProcessState.BACKOFF:
            self._tick(at_s)

    def _tick(self, at_s: float) -> None:
        if self.machine.deadline is not None:
            self.machine.deadline = min(self.machine.deadline, at_s)
        self._by_itself(MachineCommand.TICK, at_s)

    def noted_refusal(self, at_s: float, why: str) -> None:
        """Systemd does not restart it any more."""
        self.noted_restart(at_s)
        if self.machine.state is ProcessState.STARTING and not self._is_starting:
            self._handle(SpawnError(errno.ECANCELED, why), at_s)

    # ---- what is seen

    def seen(self, found: Mapping[str, str], at_s: float) -> None:
        """Compare with the state of the unit; what is missing in the journal counts as seen."""
        if self._pending is not None or self._is_starting or not self._contradicts(found):
            self._doubt.clear()
            return
        if not self._doubt.is_settled():
            return
        self._doubt.clear()
        if is_running(found):
            self.noted_start(found.get("InvocationID", ""), int(found.get("MainPID") or 0), at_s)
        elif self.machine.state.is_alive and self._invocation not in self._exits:
            is_stopping = self.machine.state is ProcessState.STOPPING
            stopped_by = self.machine.stop_signal if is_stopping else None
            outcome = outcome_of_unit(found, stopped_by)
            self.noted_exit(self._invocation, outcome, at_s)
        elif was_stopped(found) and self.machine.state is ProcessState.BACKOFF:
            self.noted_stop(at_s, by_user=True)  # which is not in the journal
        else:
            self.noted_refusal(at_s, f"systemd does not restart it ({found.get('Result', '')})")

    def _contradicts(self, found: Mapping[str, str]) -> bool:
        state = self.machine.state
        if is_running(found):
            return not (state.is_alive and found.get("InvocationID") == self._invocation)
        is_over = found.get("ActiveState") in ("inactive", "failed")
        if state is ProcessState.BACKOFF:
            return is_over and self.restarts_by_itself
        return state.is_alive and (is_over or found.get("SubState") == "auto-restart")

    def lost(self, at_s: float) -> None:
        """The host was restarted: the process has ended, and systemd does not restart it."""
        self._flush()
        self._is_starting = False
        if self.machine.state.is_alive:
            if self.machine.state is ProcessState.STARTING:
                self._handle(MachineCommand.STARTED, at_s)
            self._exit(Outcome(returncode=_KILLED), at_s)
        self._is_own = True
        self._set_timer()

    def adopt(self, found: Mapping[str, str], since_s: float) -> ProcessState:
        """Take the unit as it is; the state that the process has."""
        self._invocation = found.get("InvocationID", "")
        state = state_of(found)
        if state is ProcessState.RUNNING:
            self._invocations.append(self._invocation)
            self.pid = int(found["MainPID"])
        self.machine.adopt(state, since_s, int(found.get("NRestarts") or 0))
        return state

    # ---- timers

    def _set_timer(self) -> None:
        """None while its exit is known, or may be among the events that are still to be read."""
        self._timers.cancel("deadline")
        deadline = self.machine.deadline
        waits = self._is_suspended or self._pending is not None
        if deadline is not None and not self.restarts_by_itself and not waits:
            self._timers.after("deadline", deadline - self._reactor.now(), self._due)

    def _due(self) -> None:
        if self.machine.state is ProcessState.STOPPING:
            script = self._scripts().show([self.order.name])
            self._request(ScriptRequest(script, self._escalate, lasts=False))
        else:
            self._handle(MachineCommand.TICK, self._reactor.now())

    def _escalate(self, answer: ScriptResult) -> None:
        """Unless the unit has ended, whose record is behind much output."""
        found = (read_properties(answer.text) or [{}])[-1]
        if self._pending is None and not self._contradicts(found):
            self._handle(MachineCommand.TICK, self._reactor.now())

    def suspend_timers(self) -> None:
        """The host cannot be reached."""
        self._is_suspended = True
        self._set_timer()

    def resume_timers(self) -> None:
        """It can, and its past events have been read."""
        self._is_suspended = False
        self._set_timer()

    def close(self) -> None:
        self._timers.close()


def _is_pause(signum: int) -> bool:
    return signum in (signal.SIGSTOP, signal.SIGCONT)
