"""Events of processes, and matchers that select processes."""

from __future__ import annotations

import signal as signals
from collections.abc import Callable, Mapping

from launcher.language.class_tools import ensure_argument_type
from launcher.language.events.base import Event
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    ProcessMatcher = Callable[[Any], bool]


@public("launch.events.process.running_process_event")
class RunningProcessEvent(Event):
    """Base of events of a process that was started."""

    name = "launch.events.process.RunningProcessEvent"
    action: Any = read_only("The action that started the process.")
    execute_process_action: object = read_only(
        "The action that started the process, under its old name.", of="__action"
    )
    process_name: str = read_only("The label with the number of the process.", of="__name")
    cmd: list[str] = read_only()
    cwd: str | None = read_only("The working directory, None for the launcher's own.")
    env: Mapping[str, str] | None = read_only()
    pid: int = read_only()

    def __init__(
        self,
        *,
        action: Any,
        name: str,
        cmd: list[str],
        cwd: str | None,
        env: Mapping[str, str] | None,
        pid: int,
        **kwargs: object,
    ) -> None:
        super().__init__(**kwargs)
        self.__action = action
        self.__name = name
        self.__cmd = cmd
        self.__cwd = cwd
        self.__env = env
        self.__pid = pid


@public("launch.events.process.process_started")
class ProcessStarted(RunningProcessEvent):
    """A process was started."""

    name = "launch.events.process.ProcessStarted"


@public("launch.events.process.process_exited")
class ProcessExited(RunningProcessEvent):
    """A process exited."""

    name = "launch.events.process.ProcessExited"
    returncode: int = read_only("The exit code, negative for a signal.")

    def __init__(self, *, returncode: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__returncode = returncode


@public("launch.events.process.process_io")
class ProcessIO(RunningProcessEvent):
    """Bytes of a process's standard streams."""

    name = "launch.events.process.ProcessIO"
    text: bytes = read_only()

    def __init__(self, *, text: bytes, fd: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__text = text
        self.__from_fd = fd

    @property
    def from_stdin(self) -> bool:
        """Whether they were written to standard input."""
        return self.__from_fd == 0

    @property
    def from_stdout(self) -> bool:
        """Whether they came from standard output."""
        return self.__from_fd == 1

    @property
    def from_stderr(self) -> bool:
        """Whether they came from standard error."""
        return self.__from_fd == 2


@public("launch.events.process.process_stdin")
class ProcessStdin(ProcessIO):
    """Bytes for the standard input of a process."""

    name = "launch.events.process.ProcessStdin"

    def __init__(self, *, text: bytes, **kwargs: object) -> None:
        super().__init__(text=text, fd=0, **kwargs)


@public("launch.events.process.process_stdout")
class ProcessStdout(ProcessIO):
    """Bytes from the standard output of a process."""

    name = "launch.events.process.ProcessStdout"

    def __init__(self, *, text: bytes, **kwargs: object) -> None:
        super().__init__(text=text, fd=1, **kwargs)


@public("launch.events.process.process_stderr")
class ProcessStderr(ProcessIO):
    """Bytes from the standard error of a process."""

    name = "launch.events.process.ProcessStderr"

    def __init__(self, *, text: bytes, **kwargs: object) -> None:
        super().__init__(text=text, fd=2, **kwargs)


@public("launch.events.process.process_targeted_event")
class ProcessTargetedEvent(Event):
    """Base of events for the processes that a matcher selects."""

    name = "launch.events.process.ProcessTargetedEvent"
    process_matcher: ProcessMatcher = read_only("Called with an ExecuteLocal action.")

    def __init__(self, *, process_matcher: ProcessMatcher) -> None:
        self.__process_matcher = process_matcher


@public("launch.events.process.shutdown_process")
class ShutdownProcess(ProcessTargetedEvent):
    """The processes are to be stopped: SIGINT, then SIGTERM, then SIGKILL."""

    name = "launch.events.process.ShutdownProcess"


@public("launch.events.process.signal_process")
class SignalProcess(ProcessTargetedEvent):
    """A signal is to be sent to the processes."""

    name = "launch.events.process.SignalProcess"
    signal: signals.Signals = read_only()

    def __init__(
        self, *, signal_number: str | signals.Signals, process_matcher: ProcessMatcher
    ) -> None:
        super().__init__(process_matcher=process_matcher)
        ensure_argument_type(
            signal_number, (str, signals.Signals), "signal_number", "SignalProcess"
        )
        self.__signal = (
            signals.Signals[signal_number] if isinstance(signal_number, str) else signal_number
        )

    @property
    def signal_name(self) -> str:
        return self.__signal.name


def matches_pid(pid: int) -> ProcessMatcher:
    """A matcher for the process with this id."""
    return _matches(lambda details: details.get("pid") == pid)


def matches_name(name: str) -> ProcessMatcher:
    """A matcher for the process with this label."""
    return _matches(lambda details: details["name"] == name)


def matches_executable(executable: str) -> ProcessMatcher:
    """A matcher for processes whose first word is this."""
    return _matches(lambda details: details["cmd"][0] == executable)


def _matches(predicate: Callable[[Mapping[str, Any]], bool]) -> ProcessMatcher:
    def matcher(action: Any) -> bool:
        return action.process_details is not None and bool(predicate(action.process_details))

    return matcher
