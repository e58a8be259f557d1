"""The state machine of the end of a run: when it stops, when it is over, its exit code.

As in `machine`, time is an argument, `handle()` returns the actions for the driver, and `deadline`
is when the driver has to send a `TICK`. There is at most one `StopAll` and one `FINISH`.

    RUNNING --a reason--> NOTIFIED --> STOPPING --nothing pending--> SWEEPING --> OVER
       |                                  ^                             ^
       +------ the launch file's own -----+                             |
       +------- nothing pending, nothing expected ----------------------+
"""

from __future__ import annotations

import enum
import signal
from collections.abc import Collection, Mapping

from launcher.base.errors import ExitCode
from launcher.base.model.events import Event, Outcome, ShutdownAsked, SignalReceived
from launcher.base.model.record import Record
from launcher.run.processes.machine_events import ReportExit

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.processes.process import Process

MAX_NAMES = 3  # of processes in a cause
REPORT_EVERY_S = 1.0  # while processes take their time to stop
# Reasons of the interpreter that are no decision of the launch file.
IDLE = "idle"
EXCEPTION = "exception in the launch file"
NOT_GIVEN = "reason not given"
BY_SERVICE = "LaunchService.shutdown() called"  # by a script, which can print what it does
OUTPUT_CLOSED = "standard output was closed"


class Phase(enum.Enum):
    """How far the shutdown has come."""

    RUNNING = enum.auto()
    NOTIFIED = enum.auto()  # the interpreter is notified; it answers with ShutdownDecided
    STOPPING = enum.auto()
    SWEEPING = enum.auto()  # all processes have exited; leftovers are being stopped
    OVER = enum.auto()


# ---- events


class Interrupted(Record):
    """The launcher got this signal."""

    signum: int


class ShutdownDecided(Record):
    """The interpreter shuts the run down, by itself or after a `Notify`.

    `is_interrupted`: the processes have got SIGINT already.
    """

    reason: str
    is_interrupted: bool = False


class StopRequested(Record):
    """A user or a limit ends the run."""

    reason: str


class ProcessEnded(Record):
    """A process exited. `report` describes an unexpected failure in the summary."""

    name: str
    end: ReportExit
    is_required: bool = False
    report: str = ""


class BudgetExceeded(Record):
    """A process exceeded a budget whose action is to stop the run."""

    name: str
    report: str


class HostFailed(Record):
    """A host was lost or could not be reached; `cause` says which."""

    cause: str


class Idle(Record):
    """An event was handled completely. `expects_more`: a timer or an event may start something.

    `is_loading`: a composable node is being loaded, which does not hold up a shutdown.
    """

    expects_more: bool
    is_loading: bool = False


class Occurrence(enum.Enum):
    """Events without a value."""

    TICK = enum.auto()  # time has passed
    OUTPUT_CLOSED = enum.auto()  # standard output has no reader any more
    LEFTOVERS_KILLED = enum.auto()  # leftovers got SIGKILL, and not because of a user
    LEFTOVERS_GONE = enum.auto()


ShutdownEvent = (
    Interrupted
    | ShutdownDecided
    | StopRequested
    | ProcessEnded
    | BudgetExceeded
    | HostFailed
    | Idle
    | Occurrence
)


# ---- actions


class WriteLog(Record):
    """Log this as a line of the launcher."""

    level: str
    text: str


class Notify(Record):
    """Pass this event to the interpreter, which answers with `ShutdownDecided`."""

    event: Event


class StopAll(Record):
    """Stop every process, the last started first; see `ShutdownDecided`."""

    reason: str
    is_interrupted: bool = False


class EndLeftovers(Record):
    """Stop leftovers, after skipping so many grace periods."""

    skipped: int


class ShutdownOrder(enum.Enum):
    """Actions without a value."""

    SKIP_GRACE_PERIODS = enum.auto()  # of all processes that are being stopped, and of leftovers
    REPORT_WAITING = enum.auto()  # log which processes are still being waited for
    FINISH = enum.auto()


ShutdownAction = WriteLog | Notify | StopAll | EndLeftovers | ShutdownOrder


class ShutdownMachine:
    """One run. `processes` is the live collection of its processes, in order of start."""

    def __init__(self, processes: Collection[Process], *, exit_when_any_dies: bool = False) -> None:
        self._processes = processes
        self._exit_when_any_dies = exit_when_any_dies
        self.stop_signal: int | None = None
        self._is_output_closed = False
        self._reason: str | None = None
        self._skipped = 0
        self._has_killed_leftovers = False
        self.phase = Phase.RUNNING
        self.deadline: float | None = None
        self.first_failure: str | None = None
        self._died: dict[str, Outcome] = {}  # how each did first
        self._over_budget: list[str] = []
        self._failed_hosts: list[str] = []
        self._end_reason = ""

    @property
    def is_stopping(self) -> bool:
        """Whether nothing may start any more."""
        return self.phase is not Phase.RUNNING

    def exit_code(self, *, has_lost_output: bool = False) -> ExitCode:
        """The exit code as things stand; a run that could not write its output has failed."""
        if self._failed_hosts:
            return ExitCode.PROCESS_FAILED
        has_killed = self._has_killed_leftovers or any(
            process.machine.had_to_be_killed for process in self._processes
        )
        if self.first_failure is None and not has_killed:
            return ExitCode.PROCESS_FAILED if has_lost_output else ExitCode.OK
        if self.stop_signal is None:
            return ExitCode.PROCESS_FAILED
        is_interrupt = self.stop_signal == signal.SIGINT
        return ExitCode.INTERRUPTED if is_interrupt else ExitCode.TERMINATED

    def causes(self, *, has_lost_output: bool = False) -> list[str]:
        """Why the exit code is not 0; empty if it is."""
        killed = [p.name for p in self._processes if p.machine.had_to_be_killed]
        causes = [_unexpected(self._died)] if self._died else []
        causes += [f"{name} is over its budget" for name in self._over_budget]
        causes += [f"{', '.join(killed)} had to be killed"] if killed else []
        causes += ["leftovers had to be killed"] if self._has_killed_leftovers else []
        causes += self._failed_hosts
        return causes + (["output was lost"] if has_lost_output else [])

    @property
    def end_reason(self) -> str:
        """What ended the run; empty if nothing was left to do."""
        return {IDLE: "", NOT_GIVEN: "the launch file"}.get(self._end_reason, self._end_reason)

    def handle(self, event: ShutdownEvent, now: float) -> list[ShutdownAction]:
        """The actions for `event`, in order."""
        match event:
            case Interrupted(signum=signum):
                return self._interrupt(signum, now)
            case Occurrence.OUTPUT_CLOSED:
                self._is_output_closed = True
                self._stop_soon(OUTPUT_CLOSED, now)
            case ShutdownDecided(reason=reason) if self.phase is Phase.RUNNING:
                stop = self._stop(reason, now, is_interrupted=event.is_interrupted)
                return [*_said(reason), *stop]
            case ShutdownDecided(reason=reason) if self.phase is Phase.NOTIFIED:
                return self._stop(reason, now)
            case StopRequested(reason=reason):
                self._stop_soon(reason, now)
            case ProcessEnded():
                self._ended(event, now)
            case BudgetExceeded(name=name, report=report):
                self.first_failure = self.first_failure or report
                self._over_budget.append(name)
                self._stop_soon(f"{name} is over its budget", now)
            case HostFailed(cause=cause):
                self._failed_hosts.append(cause)
            case Occurrence.LEFTOVERS_KILLED:
                self._has_killed_leftovers = True
            case Idle() if self._is_over(event):
                # RUNNING, STOPPING -> SWEEPING
                self.phase, self.deadline = Phase.SWEEPING, None
                return [EndLeftovers(self._skipped)]
            case Occurrence.LEFTOVERS_GONE if self.phase is Phase.SWEEPING:
                # SWEEPING -> OVER
                self.phase = Phase.OVER
                return [ShutdownOrder.FINISH]
            case Occurrence.TICK if self.deadline is not None and now >= self.deadline:
                return self._due(now)
        return []

    def _interrupt(self, signum: int, now: float) -> list[ShutdownAction]:
        is_first = self.stop_signal is None
        self.stop_signal = self.stop_signal or signum
        name = signal.Signals(signum).name
        how = "ctrl-c (SIGINT)" if signum == signal.SIGINT else name
        if not self.is_stopping:
            return self._announce(
                WriteLog("WARNING", f"user interrupted with {how}"),
                SignalReceived(signum=signum),
                now,
                reason=how,
            )
        if signum == signal.SIGHUP and is_first and self._is_output_closed:
            return []  # a closed terminal whose closed output was noticed first
        self._skipped += 1
        text = f"user interrupted with {how} again, not waiting any longer"
        return [WriteLog("WARNING", text), ShutdownOrder.SKIP_GRACE_PERIODS]

    def _ended(self, event: ProcessEnded, now: float) -> None:
        if event.end.has_died:
            self.first_failure = self.first_failure or event.report
            self._died.setdefault(event.name, event.end.outcome)
        if event.end.is_final and event.is_required:
            self._stop_soon(f"{event.name} is required and has exited", now)
        elif event.end.is_final and event.end.has_died and self._exit_when_any_dies:
            self._stop_soon(f"{event.name} died", now)

    def _stop_soon(self, reason: str, now: float) -> None:
        """Stop at the next tick, since the driver may be in the middle of something now."""
        if not self.is_stopping and self._reason is None:
            self._reason, self.deadline = reason, now

    def _announce(
        self, said: WriteLog, event: Event, now: float, *, reason: str
    ) -> list[ShutdownAction]:
        # RUNNING -> NOTIFIED
        self.phase, self._reason, self.deadline = Phase.NOTIFIED, reason, now
        return [said, Notify(event)]

    def _stop(
        self, reason: str, now: float, *, is_interrupted: bool = False
    ) -> list[ShutdownAction]:
        # RUNNING, NOTIFIED -> STOPPING
        self.phase, self.deadline = Phase.STOPPING, now + REPORT_EVERY_S
        self._end_reason = reason
        return [StopAll(reason, is_interrupted)]

    def _due(self, now: float) -> list[ShutdownAction]:
        reason = self._reason or ""
        if self.phase is Phase.RUNNING:
            said = WriteLog("INFO", f"{reason}: shutting down")
            return self._announce(said, ShutdownAsked(reason=reason), now, reason=reason)
        if self.phase is Phase.NOTIFIED:  # the interpreter has not answered
            return self._stop(reason, now)
        if not any(process.is_awaited for process in self._processes):
            self.deadline = None
            return []
        self.deadline = now + REPORT_EVERY_S
        return [ShutdownOrder.REPORT_WAITING]

    def _is_over(self, idle: Idle) -> bool:
        """Whether nothing is running and nothing can start any more."""
        if self.phase not in (Phase.RUNNING, Phase.STOPPING) or idle.expects_more:
            return False
        machines = (one.machine for one in self._processes if not one.is_abandoned)
        if self.phase is Phase.STOPPING:
            return not any(one.is_pending and not one.is_stuck for one in machines)
        return not (idle.is_loading or any(one.is_pending or one.is_held for one in machines))


def _said(reason: str) -> list[ShutdownAction]:
    """The launch file's reason for its shutdown, if it gives one."""
    if reason in (IDLE, EXCEPTION, NOT_GIVEN, BY_SERVICE, ""):
        return []
    return [WriteLog("INFO", f"shutdown requested by the launch file: {reason}")]


def _unexpected(died: Mapping[str, Outcome]) -> str:
    """`a ended unexpectedly (exit code 1)`, or `a, b, c and 2 more ended unexpectedly`."""
    names = list(died)
    if len(names) == 1:
        return f"{names[0]} ended unexpectedly ({died[names[0]]})"
    more = len(names) - MAX_NAMES
    shown, last = (names[:MAX_NAMES], f"{more} more") if more > 0 else (names[:-1], names[-1])
    return f"{', '.join(shown)} and {last} ended unexpectedly"
