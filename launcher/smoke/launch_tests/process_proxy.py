"""A process that a test starts and stops itself."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from launcher.language.actions.process import ExecuteProcess
from launcher.language.class_tools import ensure_argument_type
from launcher.language.description import LaunchDescription
from launcher.language.events.launch import IncludeLaunchDescription, matches_action
from launcher.language.events.process import ProcessExited, ProcessStarted, ShutdownProcess
from launcher.language.naming import public
from launcher.smoke.launch_tests.asserts import written
from launcher.smoke.launch_tests.observations import ActiveIoHandler, ActiveProcInfoHandler


class OutputFound:
    """True or False; its text has the output that was searched."""

    def __init__(self, found: bool, output: str | None) -> None:
        self._found = found
        self._output = output

    def __bool__(self) -> bool:
        return self._found

    def __repr__(self) -> str:
        return f"<{self._found}: {self._output!r}>"


@public("launch_testing.tools.process")
class ProcessProxy:
    """State and output of one process; `output_filter` is applied to the text."""

    def __init__(
        self,
        process_action: Any,
        proc_info: Any,
        proc_output: Any,
        *,
        output_filter: Callable[[str], str] | None = None,
    ) -> None:
        owner = "ProcessProxy"
        ensure_argument_type(process_action, ExecuteProcess, "process_action", owner)
        ensure_argument_type(proc_info, ActiveProcInfoHandler, "proc_info", owner)
        ensure_argument_type(proc_output, ActiveIoHandler, "proc_output", owner)
        if output_filter is not None and not callable(output_filter):
            raise TypeError(f"Expected 'output_filter' to be callable but got '{output_filter!r}'")
        self._action = process_action
        self._proc_info = proc_info
        self._proc_output = proc_output
        self._filter = output_filter

    def wait_for_shutdown(self, timeout: float | None = None) -> bool:
        """Whether it ends within `timeout` seconds."""
        condition = self._proc_info.proc_event
        with condition:
            return bool(condition.wait_for(lambda: self.terminated, timeout=timeout))

    def wait_for_output(
        self, condition: Callable[[str], object] | None = None, timeout: float | None = None
    ) -> OutputFound:
        """Whether `condition` is true of its output within `timeout` seconds, while it runs."""
        if condition is not None and not callable(condition):
            raise TypeError(f"Expected 'condition' to be callable but got '{condition!r}'")
        seen: str | None = None

        def is_met() -> bool:
            nonlocal seen
            if not self.running:
                return False
            seen = self.output
            return condition is None or bool(condition(seen))

        with self._proc_output.io_event:
            found = self._proc_output.io_event.wait_for(is_met, timeout=timeout)
        return OutputFound(bool(found), seen)

    @property
    def target_process_action(self) -> Any:
        return self._action

    @property
    def output(self) -> str:
        return self._text("")

    @property
    def stdout(self) -> str:
        return self._text("stdout")

    @property
    def stderr(self) -> str:
        return self._text("stderr")

    def _text(self, stream: str) -> str:
        text = written(self._proc_output[self._action], stream)
        return text if self._filter is None else self._filter(text)

    @property
    def running(self) -> bool:
        return self._is(ProcessStarted)

    @property
    def terminated(self) -> bool:
        return self._is(ProcessExited)

    def _is(self, kind: type) -> bool:
        known = self._action in self._proc_info.processes()
        return known and isinstance(self._proc_info[self._action], kind)

    @property
    def exit_code(self) -> int:
        code: int = self._proc_info[self._action].returncode
        return code


@contextlib.contextmanager
def launch_process(
    launch_service: Any, process_action: Any, proc_info: Any, proc_output: Any, **kwargs: Any
) -> Iterator[ProcessProxy]:
    """Start a process in the running service; it is stopped at the end of the block."""
    ensure_argument_type(process_action, ExecuteProcess, "process_action", "launch_process")
    launch_service.emit_event(IncludeLaunchDescription(LaunchDescription([process_action])))
    proxy = ProcessProxy(process_action, proc_info, proc_output, **kwargs)
    try:
        yield proxy
    finally:
        if not proxy.terminated:
            matcher = matches_action(process_action)
            launch_service.emit_event(ShutdownProcess(process_matcher=matcher))
