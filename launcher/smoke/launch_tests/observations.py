"""What a test observes of its processes: `proc_output` and `proc_info`.

Those named Active are filled in one thread and read in another; the others are what is left of
them after the shutdown.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

from launcher.language.events.process import ProcessExited
from launcher.language.naming import public
from launcher.smoke.launch_tests.asserts import assertInStream
from launcher.smoke.launch_tests.process_lookup import NoMatchingProcessException, resolveProcesses


@public("launch_testing.io_handler")
class IoHandler:
    """The output of processes in the order of time."""

    def __init__(self) -> None:
        self._events: list[Any] = []
        self._events_of: dict[str, list[Any]] = {}

    def track(self, process_name: str) -> None:
        """Have a row, still without output, for this process."""
        self._events_of.setdefault(process_name, [])

    def append(self, process_io: Any) -> None:
        self._events.append(process_io)
        self._events_of.setdefault(process_io.process_name, []).append(process_io)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._events)

    def processes(self) -> list[Any]:
        """The actions of the processes that have written something."""
        return [events[0].action for events in self._events_of.values() if events]

    def process_names(self) -> Any:
        return self._events_of.keys()

    def __getitem__(self, key: Any) -> list[Any]:
        """The events of a process, by its full name or its action; KeyError if it has none."""
        name = key if isinstance(key, str) else key.process_details["name"]
        return list(self._events_of[name])


@public("launch_testing.io_handler")
class ActiveIoHandler:
    """The output of running processes, which can be waited for."""

    def __init__(self) -> None:
        self._sync_lock = threading.Condition()
        self._io_handler = IoHandler()

    @property
    def io_event(self) -> threading.Condition:
        return self._sync_lock

    def track(self, process_name: str) -> None:
        with self._sync_lock:
            self._io_handler.track(process_name)
            self._sync_lock.notify_all()

    def append(self, process_io: Any) -> None:
        with self._sync_lock:
            self._io_handler.append(process_io)
            self._sync_lock.notify_all()

    def __iter__(self) -> Iterator[Any]:
        with self._sync_lock:
            return iter(list(self._io_handler))

    def processes(self) -> list[Any]:
        with self._sync_lock:
            return self._io_handler.processes()

    def process_names(self) -> list[str]:
        with self._sync_lock:
            return list(self._io_handler.process_names())

    def __getitem__(self, key: Any) -> list[Any]:
        with self._sync_lock:
            return self._io_handler[key]

    def assertWaitFor(self, *args: Any, **kwargs: Any) -> None:
        """`waitFor`; an AssertionError instead of False."""
        if not self.waitFor(*args, **kwargs):
            raise AssertionError("Waiting for output timed out")

    def waitFor(
        self,
        expected_output: Any,
        process: Any = None,
        cmd_args: Any = None,
        *,
        strict_proc_matching: bool = True,
        output_filter: Callable[[str], str] | None = None,
        timeout: float = 10,
        strip_ansi_escape_sequences: bool = True,
        stream: str = "stderr",
    ) -> bool:
        """Whether the output has this within `timeout` seconds, as `assertInStream` decides it.

        NoMatchingProcessException if no such process has written anything until then.
        """

        def is_there() -> bool:
            try:
                assertInStream(
                    self._io_handler,
                    expected_output,
                    process,
                    cmd_args,
                    output_filter=output_filter,
                    strict_proc_matching=strict_proc_matching,
                    strip_ansi_escape_sequences=strip_ansi_escape_sequences,
                    stream=stream,
                )
            except (AssertionError, NoMatchingProcessException):
                return False
            return True

        with self._sync_lock:
            if self._sync_lock.wait_for(is_there, timeout=timeout):
                return True
        resolveProcesses(self, process=process, cmd_args=cmd_args, strict_proc_matching=False)
        return False


@public("launch_testing.proc_info_handler")
class ProcInfoHandler:
    """The last event of each process: ProcessStarted, or ProcessExited with its `returncode`."""

    def __init__(self) -> None:
        self._events: dict[Any, Any] = {}

    def append(self, process_info: Any) -> None:
        self._events[process_info.action] = process_info

    def __iter__(self) -> Iterator[Any]:
        return iter(self._events.values())

    def processes(self) -> Any:
        return self._events.keys()

    def process_names(self) -> list[str]:
        return [action.process_details["name"] for action in self._events]

    def __getitem__(self, key: Any) -> Any:
        """The event of an action, or of the first process with this text in its name."""
        if not isinstance(key, str):
            return self._events[key]
        for action, event in self._events.items():
            if key in action.process_details["name"]:
                return event
        raise KeyError(key)


@public("launch_testing.proc_info_handler")
class ActiveProcInfoHandler:
    """The last events of running processes, whose start and end can be waited for."""

    def __init__(self) -> None:
        self._sync_lock = threading.Condition()
        self._proc_info_handler = ProcInfoHandler()

    @property
    def proc_event(self) -> threading.Condition:
        return self._sync_lock

    def append(self, process_info: Any) -> None:
        with self._sync_lock:
            self._proc_info_handler.append(process_info)
            self._sync_lock.notify_all()

    def __iter__(self) -> Iterator[Any]:
        with self._sync_lock:
            return iter(list(self._proc_info_handler))

    def processes(self) -> list[Any]:
        with self._sync_lock:
            return list(self._proc_info_handler.processes())

    def process_names(self) -> list[str]:
        with self._sync_lock:
            return self._proc_info_handler.process_names()

    def __getitem__(self, key: Any) -> Any:
        with self._sync_lock:
            return self._proc_info_handler[key]

    def assertWaitForStartup(
        self, process: Any, cmd_args: Any = None, *, timeout: float = 10
    ) -> None:
        """Wait until the process has started; AssertionError after `timeout` seconds."""
        self._wait(process, cmd_args, timeout, lambda event: True, "start")

    def assertWaitForShutdown(
        self, process: Any, cmd_args: Any = None, *, timeout: float = 10
    ) -> None:
        """Wait until the process has ended; AssertionError after `timeout` seconds."""
        self._wait(
            process, cmd_args, timeout, lambda event: isinstance(event, ProcessExited), "finish"
        )

    def _wait(
        self, process: Any, cmd_args: Any, timeout: float, fits: Callable[[Any], bool], what: str
    ) -> None:
        handler = self._proc_info_handler

        def is_true() -> bool:
            try:
                found = resolveProcesses(handler, process=process, cmd_args=cmd_args)
            except NoMatchingProcessException:
                return False
            return fits(handler[found[0]])

        with self._sync_lock:
            if not self._sync_lock.wait_for(is_true, timeout=timeout):
                raise AssertionError(f"Timed out waiting for process '{process}' to {what}")


@public("launch_testing.ready_aggregator")
class ReadyAggregator:
    """Calls a function at the n-th call of `ready_fn`, from any thread."""

    def __init__(self, ready_fn: Callable[[], object], num_to_aggregate: int) -> None:
        self._function = ready_fn
        self._left = num_to_aggregate
        self._lock = threading.Lock()

    def ready_fn(self) -> None:
        with self._lock:
            self._left -= 1
            is_last = self._left == 0
        if is_last:
            self._function()
