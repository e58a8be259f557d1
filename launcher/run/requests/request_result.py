"""The result of the request of a user for one process."""

from __future__ import annotations

import enum

from launcher.base.model.events import Outcome
from launcher.base.model.record import Record
from launcher.run.processes.machine_events import ProcessState


class Kind(enum.Enum):
    """The outcome of a request; the comments name the fields of `Result` that are set."""

    NOT_RUNNING = enum.auto()  # state
    ENDED = enum.auto()
    STUCK = enum.auto()
    # stop and restart
    STOPPED = enum.auto()  # elapsed_s, signum, exit
    RESTART_CANCELLED = enum.auto()
    START_CANCELLED = enum.auto()
    # start and restart
    RUN_STOPPING = enum.auto()
    QUEUED = enum.auto()
    ALREADY_RUNNING = enum.auto()  # pid
    STARTED = enum.auto()  # pid; of a restart old_pid and stopped
    START_FAILED = enum.auto()  # exit; of a restart stopped
    OVERTAKEN = enum.auto()  # a later stop counts
    UNDER_DEBUGGER = enum.auto()  # it was not restarted for a change
    # signals
    EXISTS = enum.auto()  # pid
    SIGNALLED = enum.auto()  # signum
    SURVIVED = enum.auto()  # signum
    ENDED_BY_SIGNAL = enum.auto()  # elapsed_s, signum, exit
    ALREADY_SUSPENDED = enum.auto()
    NOT_SUSPENDED = enum.auto()
    SUSPENDED = enum.auto()  # signum
    RESUMED = enum.auto()  # signum
    WITHOUT_EFFECT = enum.auto()  # signum
    # standard input
    WRITTEN = enum.auto()  # written
    PARTLY_WRITTEN = enum.auto()  # written, size
    NOT_WRITTEN = enum.auto()  # errno
    NO_INPUT = enum.auto()  # it is composed
    # processes on other hosts: host, elapsed_s since its last message
    UNREACHABLE = enum.auto()  # nothing was requested
    STOP_WAITS = enum.auto()  # until the host can be reached
    LINK_LOST = enum.auto()  # after it was requested
    HOST_LOST = enum.auto()  # for ever: it cannot be started; host


class Result(Record):
    """The outcome of a request for one process, and whether it was `done`.

    `stopped` is the result of the first half of a restart. `restart_disabled`: its restart policy
    does not apply any more, because a user has stopped it.
    """

    process: str
    kind: Kind
    done: bool
    state: ProcessState | None = None
    elapsed_s: float = 0.0
    signum: int = 0
    exit: Outcome | None = None
    pid: int | None = None
    old_pid: int | None = None
    stopped: Result | None = None
    written: int = 0
    size: int = 0
    errno: int = 0
    restart_disabled: bool = False
    host: str = ""
