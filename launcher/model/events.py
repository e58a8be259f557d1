"""Effects that the interpreter asks for, and events that its driver reports back.

The interpreter is sans-I/O: `start()` and `handle(event)` return effects in order. A driver
carries them out (the supervisor for real, the planner in virtual time) and feeds back what
happened. `process_id` and `timer_id` are small numbers that the interpreter gives out; they are
not pids.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from launcher.model.spec import ProcessSpec

# ---- effects: interpreter -> driver


@dataclass(frozen=True, slots=True, kw_only=True)
class StartProcess:
    """Start this process now; answer with ProcessStarted or SpawnFailed."""

    process_id: int
    spec: ProcessSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalProcess:
    """Send this signal once to the group of the process, if it lives."""

    process_id: int
    signum: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StopProcess:
    """Stop one process by its StopPolicy; it is not restarted."""

    process_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteStdin:
    """Write these bytes to the standard input of the process."""

    process_id: int
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class CallLater:
    """Answer with TimerFired(timer_id) after `delay_s` seconds."""

    timer_id: int
    delay_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CancelTimer:
    """Forget this timer; TimerFired for it is ignored from now on."""

    timer_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LogMessage:
    """A line of the launcher's own: `[LEVEL] [logger]: text`."""

    logger: str
    level: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestShutdown:
    """Stop every process in order and end the run."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadRequest:
    """A composable node for a container; parameters and extra arguments are (name, value)."""

    container: str
    package: str
    plugin: str
    name: str | None = None
    namespace: str | None = None
    remappings: tuple[tuple[str, str], ...] = ()
    parameters: tuple[tuple[str, object], ...] = ()
    extra_arguments: tuple[tuple[str, object], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadComponent:
    """Ask the container to load the node; answer with ComponentLoaded(request_id)."""

    request_id: int
    request: LoadRequest


@dataclass(frozen=True, slots=True, kw_only=True)
class StateRequest:
    """A transition of the lifecycle node with this full name, by id and by label."""

    node: str
    transition_id: int
    transition: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangeState:
    """Ask the lifecycle node for the transition; answer with StateChanged(request_id)."""

    request_id: int
    request: StateRequest


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchLifecycle:
    """From now on tell the transitions of this node as TransitionSeen."""

    node: str


# ---- events: driver -> interpreter


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessStarted:
    """The process was exec'd, also after a restart."""

    process_id: int
    pid: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessExited:
    """The process ended; `returncode` is negative for a signal, as in `subprocess`.

    `will_restart` tells that its RestartPolicy starts it again.
    """

    process_id: int
    pid: int
    returncode: int
    will_restart: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class SpawnFailed:
    """The process could not be started; `errno` and `reason` as the operating system says."""

    process_id: int
    errno: int
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessOutput:
    """Bytes that the process wrote; `stream` is `stdout` or `stderr`.

    Sent only for processes that the interpreter watches (`Interpreter.watches_output`).
    """

    process_id: int
    stream: str
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class TimerFired:
    """The time of a CallLater has come."""

    timer_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalReceived:
    """The launcher itself got SIGINT, SIGTERM or SIGHUP and is going to stop everything."""

    signum: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentLoaded:
    """The container answered a LoadComponent; `error` is None if the node was loaded."""

    request_id: int
    full_node_name: str = ""
    unique_id: int = 0
    error: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StateChanged:
    """The lifecycle node answered a ChangeState; `error` is None if it accepted it."""

    request_id: int
    error: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class TransitionSeen:
    """A lifecycle node went from one state to another, by their labels (`inactive`)."""

    node: str
    transition: str
    start_state: str
    goal_state: str


Effect = Union[
    StartProcess,
    SignalProcess,
    StopProcess,
    WriteStdin,
    CallLater,
    CancelTimer,
    LogMessage,
    RequestShutdown,
    LoadComponent,
    ChangeState,
    WatchLifecycle,
]
Event = Union[
    ProcessStarted,
    ProcessExited,
    SpawnFailed,
    ProcessOutput,
    TimerFired,
    SignalReceived,
    ComponentLoaded,
    StateChanged,
    TransitionSeen,
]
