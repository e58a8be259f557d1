"""Effects that the interpreter requests, and events that its driver reports.

The interpreter does no I/O: `start()` and `handle(event)` return effects in order. A driver (the
supervisor, or the planner in virtual time) carries them out and reports events. `process_id` and
`timer_id` are numbers that the interpreter assigns, not pids.
"""

from __future__ import annotations

import errno
import os
import signal

from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

# ---- effects: interpreter -> driver


class StartProcess(Record):
    """Start this process now; answer with ProcessStarted or SpawnFailed."""

    process_id: int
    spec: ProcessSpec


class SignalProcess(Record):
    """Send this signal once to the group of the process, if it is running."""

    process_id: int
    signum: int


class StopProcess(Record):
    """Stop one process by its StopPolicy; it is not restarted."""

    process_id: int


class WriteStdin(Record):
    """Write these bytes to the standard input of the process."""

    process_id: int
    data: bytes


class CallLater(Record):
    """Answer with TimerFired(timer_id) after `delay_s` seconds.

    They count from the first start among the effects of the same moment, which may take a while.
    The shutdown of the run waits for a timer that outlives it, and cancels all others. The ROS
    clock is wall time, or that of a simulation after UseSimTime. `is_step`: not a timer of the
    launch file, but the next step of the interpreter, which waits for no start.
    """

    timer_id: int
    delay_s: float
    outlives_shutdown: bool = False
    on_ros_clock: bool = False
    is_step: bool = False


class UseSimTime(Record):
    """From now on the ROS clock of the run is that of the simulation (`/clock`), or wall time."""

    value: bool


class CancelTimer(Record):
    """Cancel this timer; a later TimerFired for it is ignored."""

    timer_id: int


class LogMessage(Record):
    """A message of the launcher: `[LEVEL] [logger]: text`.

    `sink` is `screen` or `log` if it goes only there; `line` is the whole line, formatted already.
    """

    logger: str
    level: str
    text: str
    sink: str = ""
    line: str | None = None


class RequestShutdown(Record):
    """Stop every process in order and end the run.

    `is_interrupted`: the processes have got SIGINT already, from the terminal.
    """

    reason: str
    is_interrupted: bool = False


class LoadRequest(Record):
    """A composable node for a container; parameters and extra arguments are (name, value)."""

    container: str
    package: str
    plugin: str
    name: str | None = None
    namespace: str | None = None
    remappings: tuple[tuple[str, str], ...] = ()
    parameters: tuple[tuple[str, object], ...] = ()
    extra_arguments: tuple[tuple[str, object], ...] = ()

    @property
    def full_name(self) -> str:
        """The name with its namespace; empty if the plug-in chooses the name."""
        return f"{(self.namespace or '').rstrip('/')}/{self.name}" if self.name else ""


class LoadComponent(Record):
    """Ask the container to load the node; answer with ComponentLoaded(request_id).

    `place` is the file and line of the action. It asks for those in `rest` after the answer.
    """

    request_id: int
    request: LoadRequest
    place: str = "the launch file"
    rest: tuple[LoadRequest, ...] = ()


class StateRequest(Record):
    """A transition of the lifecycle node with this full name, by id and by label."""

    node: str
    transition_id: int
    transition: str


class ChangeState(Record):
    """Ask the lifecycle node for the transition; answer with StateChanged(request_id)."""

    request_id: int
    request: StateRequest


class WatchLifecycle(Record):
    """From now on report the transitions of this node as TransitionSeen."""

    node: str


# ---- events: driver -> interpreter


class ProcessStarted(Record):
    """The process was exec'd, also after a restart."""

    process_id: int
    pid: int


class ProcessExited(Record):
    """The process exited; `returncode` is negative for a signal, as in `subprocess`.

    `will_restart`: its RestartPolicy restarts it, or a user has stopped it and may start it again.
    """

    process_id: int
    pid: int
    returncode: int
    will_restart: bool = False


class MemberExited(Record):
    """One of the nodes of a composed process has ended; `index` is its place there.

    `with_process`: somebody has asked the process to end.
    """

    process_id: int
    index: int
    pid: int
    returncode: int
    with_process: bool = False


class SpawnFailed(Record):
    """The process could not be started; `errno` and `reason` are those of the system call.

    `will_restart` is as in ProcessExited.
    """

    process_id: int
    errno: int
    reason: str
    will_restart: bool = False


class ProcessOutput(Record):
    """Bytes that the process wrote; `stream` is `stdout` or `stderr`.

    Sent only for processes that the interpreter watches (`Interpreter.watches_output`).
    """

    process_id: int
    stream: str
    data: bytes


class TimerFired(Record):
    """The delay of a CallLater has passed."""

    timer_id: int


class TimerLost(Record):
    """The timer will never fire."""

    timer_id: int
    reason: str


class SignalReceived(Record):
    """The launcher itself got SIGINT, SIGTERM or SIGHUP and is going to stop everything."""

    signum: int


class ShutdownAsked(Record):
    """The run ends not by a signal or the launch file, but by a user, a limit or a failure."""

    reason: str


class Emitted(Record):
    """A LaunchService got this event of the launch language, from outside of the run."""

    event: Any


class ComponentLoaded(Record):
    """The container answered a LoadComponent; `error` is None if the node was loaded."""

    request_id: int
    full_node_name: str = ""
    unique_id: int = 0
    error: str | None = None


class StateChanged(Record):
    """The lifecycle node answered a ChangeState; `error` is None if it accepted it."""

    request_id: int
    error: str | None = None


class TransitionSeen(Record):
    """A lifecycle node went from one state to another, by their labels (`inactive`).

    `stamp_ns` is the time on the node's clock, 0 in virtual time.
    """

    node: str
    transition: str
    start_state: str
    goal_state: str
    stamp_ns: int = 0


Effect = (
    StartProcess
    | SignalProcess
    | StopProcess
    | WriteStdin
    | CallLater
    | CancelTimer
    | UseSimTime
    | LogMessage
    | RequestShutdown
    | LoadComponent
    | ChangeState
    | WatchLifecycle
)
Event = (
    ProcessStarted
    | ProcessExited
    | MemberExited
    | SpawnFailed
    | ProcessOutput
    | TimerFired
    | TimerLost
    | SignalReceived
    | ShutdownAsked
    | Emitted
    | ComponentLoaded
    | StateChanged
    | TransitionSeen
)


# ---- how a process ended


SIGNALLED = 128  # a shell adds it to the number of the signal that has ended its command


def refusal(number: int, what: str) -> str:
    """Why a start failed, by its errno; `what` is the cause if it is not the program."""
    if number == errno.ETIMEDOUT and what:  # it has waited for others, as `what` says
        return what
    return f"{what}: {os.strerror(number)}" if what else os.strerror(number)


class Outcome(Record):
    """The exit or failed start of a process: exactly one of the first two is set.

    `spawn_what` is the cause of a failed start if it is not the program, for example a limit.
    `core_dumped` and `out_of_memory` are details of an exit by a signal. `lost_with` is the host
    with which it was lost: the return code is then that of SIGKILL.
    """

    returncode: int | None = None
    spawn_errno: int | None = None
    spawn_what: str = ""
    core_dumped: bool = False
    out_of_memory: bool = False
    lost_with: str = ""

    @property
    def failed(self) -> bool:
        """Whether this is a failure (a code other than 0, a signal, or no start at all)."""
        return self.returncode != 0

    def __str__(self) -> str:
        if self.spawn_errno is not None:
            return f"could not be started: {refusal(self.spawn_errno, self.spawn_what)}"
        if self.lost_with:
            return f"lost with {self.lost_with}"
        if self.returncode is not None and self.returncode < 0:
            return signal_name(-self.returncode) + self._remark
        return f"exit code {self.returncode}"

    @property
    def _remark(self) -> str:
        if self.out_of_memory:
            return ", out of memory"
        return ", core dumped" if self.core_dumped else ""


def signal_name(signum: int) -> str:
    """`SIGSEGV` for 11; `signal 40` for one without a name."""
    try:
        return signal.Signals(signum).name
    except ValueError:
        return f"signal {signum}"
