"""What the machine of a process takes and asks for: its states, events and actions."""

from __future__ import annotations

import enum
import signal

from launcher.base.model.events import Outcome
from launcher.base.model.record import Record

# Signals that ask a program to exit; it may catch them and clean up.
POLITE = frozenset({signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT})


class ProcessState(enum.Enum):
    """The states, by the names of supervisord."""

    STOPPED = "STOPPED"  # never started, or stopped on request
    STARTING = "STARTING"  # is being spawned
    RUNNING = "RUNNING"
    BACKOFF = "BACKOFF"  # exited, and waits for its restart
    STOPPING = "STOPPING"  # signalled, and has not exited yet
    EXITED = "EXITED"  # exited by itself, and is not restarted
    FATAL = "FATAL"  # failed, and its restarts are used up or it cannot be started

    @property
    def is_alive(self) -> bool:
        """Whether a process may exist in this state."""
        return self in (ProcessState.STARTING, ProcessState.RUNNING, ProcessState.STOPPING)


class SpawnError(Record):
    """The spawn failed with this errno; `what` names the culprit if it is not the program."""

    errno: int
    what: str = ""


class Exited(Record):
    """The process exited; `outcome` has a return code."""

    outcome: Outcome


class SignalSent(Record):
    """This signal was sent to it. An exit by a signal of a user counts as requested."""

    signum: int
    by_user: bool = True


class MachineCommand(enum.Enum):
    """Events without a value."""

    START = enum.auto()  # by the launch file
    USER_START = enum.auto()
    STARTED = enum.auto()  # the spawn succeeded
    STOP = enum.auto()  # with the run, or by the launch file
    INTERRUPTED = enum.auto()  # a stop whose SIGINT it has got from elsewhere
    USER_STOP = enum.auto()  # it may be started again
    RESTART = enum.auto()  # stop it and start it again at once
    SKIP_GRACE = enum.auto()  # send the next signal of the stop, or the first, now
    SUSPEND = enum.auto()  # by a user
    RESUME = enum.auto()
    START_CANCELLED = enum.auto()  # it was stopped while it was queued to start
    TICK = enum.auto()  # time has passed


MachineEvent = MachineCommand | SpawnError | Exited | SignalSent


class Signal(Record):
    """Send this signal to its group."""

    signum: signal.Signals

    @property
    def needs_wake(self) -> bool:
        """Whether to `WAKE` it, too, in case it is suspended."""
        return self.signum in POLITE


class Escalate(Record):
    """Report that it did not exit within `waited_s` after the signal `after`; `to` comes next."""

    after: signal.Signals
    waited_s: float
    to: signal.Signals


class ReportStuck(Record):
    """Report that it still exists `waited_s` after SIGKILL."""

    waited_s: float


class ReportExit(Record):
    """Report its exit. `asked`: as it was requested. `retry_in_s`: None if it is not restarted.

    `sent`: it exited by a signal of a user (`SignalSent`), which implies `asked`. `crashed`: it was
    being stopped, and ended by a signal that nobody had sent, which is not `asked`.
    """

    outcome: Outcome
    asked: bool
    retry_in_s: float | None
    sent: bool = False
    crashed: bool = False

    @property
    def is_final(self) -> bool:
        """Whether the exit was by itself, and no restart follows."""
        return self.retry_in_s is None and not self.asked and not self.crashed

    @property
    def has_died(self) -> bool:
        """Whether it failed, and no restart follows because of that."""
        return self.crashed or (self.is_final and self.outcome.failed)


class MachineAction(enum.Enum):
    """Actions without a value."""

    SPAWN = enum.auto()
    # Send SIGCONT: a suspended process cannot handle any signal but SIGKILL. Other processes in
    # the group do not notice it, unless they handle SIGCONT.
    WAKE = enum.auto()


Action = MachineAction | Signal | Escalate | ReportStuck | ReportExit
