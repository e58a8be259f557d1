"""launch_testing.legacy: a service that ends when processes have done what is expected of them."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Iterable
from typing import Any

from launcher.language.action import Action
from launcher.language.actions.event_actions import EmitEvent, RegisterEventHandler
from launcher.language.actions.process import ExecuteProcess, OnProcessExit, OnProcessIO
from launcher.language.events.handlers import OnExecutionComplete, OnShutdown
from launcher.language.events.launch import Shutdown
from launcher.language.naming import public
from launcher.smoke.launch_tests.text_matching import FILTERED_PREFIXES

OutputTest = tuple[Any, Callable[[Any, bytes], Any], Callable[[Any, Any], bool], Iterable[Any]]


@public("launch_testing.legacy")
class LaunchTestService:
    """Shuts the system down when all tests have ended or a fixture process exits unexpectedly."""

    def __init__(self) -> None:
        self.__running: list[object] = []
        self.__failed_with: int | None = None

    def add_fixture_action(
        self, launch_description: Any, action: Action, exit_allowed: object = (0,)
    ) -> Action:
        """Add a fixture of the tests; `exit_allowed`: exit codes it may have, or True for any."""
        launch_description.add_action(action)
        if isinstance(action, ExecuteProcess):
            handler = OnProcessExit(
                target_action=action,
                on_exit=lambda event, context: self.__fixture_ended(event, context, exit_allowed),
            )
            launch_description.add_action(RegisterEventHandler(handler))
        return action

    def add_test_action(self, launch_description: Any, action: Action) -> Action:
        """Add a test. The end of the last test, or a nonzero exit code, shuts the system down."""
        handler: Any
        if isinstance(action, ExecuteProcess):
            handler = OnProcessExit(
                target_action=action, on_exit=lambda event, _: self.__test_ended(action, event)
            )
        else:
            handler = OnExecutionComplete(
                target_action=action, on_completion=lambda *_: self.__test_passed(action)
            )
        launch_description.add_action(RegisterEventHandler(handler))
        launch_description.add_action(action)
        self.__running.append(action)
        return action

    def __fixture_ended(self, event: Any, context: Any, exit_allowed: Any) -> Any:
        allowed = exit_allowed
        if isinstance(exit_allowed, (list, tuple)):
            allowed = event.returncode in exit_allowed
        if allowed or context.is_shutdown:
            return None
        self.__failed_with = event.returncode or 1
        return _shutdown(f"{event.process_name} fixture process died!")

    def __test_ended(self, action: Action, event: Any) -> Any:
        if event.returncode == 0:
            return self.__test_passed(action)
        self.__failed_with = event.returncode
        self.__running.clear()
        return _shutdown(f"{event.process_name} test failed!")

    def __test_passed(self, test: object) -> Any:
        if test in self.__running:
            self.__running.remove(test)
        return [] if self.__running else _shutdown("all tests finished")

    def add_output_test(
        self,
        launch_description: Any,
        action: Action,
        output_test: tuple[Any, Any, Any, Iterable[Any]],
        test_suffix: str = "output",
        output_filter: Callable[[bytes], bytes] | None = None,
        side_effect: str | None = None,
    ) -> Action:
        """Add a test of what a process writes, as `launch_testing.legacy.output` makes it.

        `side_effect` "shutdown": shut the system down when everything has been written.
        """
        output, collate, match, patterns = output_test
        left = list(patterns)
        test = (action, test_suffix)

        def written(event: Any) -> Any:
            nonlocal output
            text = event.text if output_filter is None else output_filter(event.text)
            output = collate(output, text)
            left[:] = [pattern for pattern in left if not match(output, pattern)]
            if left:
                return None
            next_steps = self.__test_passed(test)
            return _shutdown("shutdown after test") if side_effect == "shutdown" else next_steps

        def shut_down(event: Any, context: Any) -> None:
            if left and not self.__failed_with:
                self.__failed_with = 1

        for handler in (
            OnProcessIO(target_action=action, on_stdout=written),
            OnProcessExit(target_action=action, on_exit=lambda *_: self.__test_passed(test)),
            OnShutdown(on_shutdown=shut_down),
        ):
            launch_description.add_action(RegisterEventHandler(handler))
        self.__running.append(test)
        return action

    def run(self, launch_service: Any, *args: Any, **kwargs: Any) -> int:
        """Run the service; its return code, or that of the last test that failed."""
        code: int = launch_service.run(*args, **kwargs)
        return self.__failed_with if code == 0 and self.__failed_with else code


def _shutdown(reason: str) -> list[EmitEvent]:
    return [EmitEvent(event=Shutdown(reason=reason))]


def create_output_lines_filter(
    filtered_prefixes: Iterable[bytes] | None = None,
    filtered_patterns: Iterable[bytes] | None = None,
    filtered_rmw_implementation: str | None = None,
) -> Callable[[bytes], bytes]:
    """A function that leaves out lines by their beginning or by a pattern."""
    prefixes = tuple(filtered_prefixes or (one.encode() for one in FILTERED_PREFIXES))
    patterns = [re.compile(one) for one in filtered_patterns or ()]

    def filtered(output: bytes) -> bytes:
        return b"".join(
            line
            for line in output.splitlines(keepends=True)
            if not line.startswith(prefixes) and not any(one.match(line) for one in patterns)
        )

    return filtered


def create_output_lines_test(expected_lines: Iterable[bytes]) -> OutputTest:
    """The test that each of these is a part of some line."""
    return io.BytesIO(), _collate, _has_line, expected_lines


def create_output_regex_test(expected_patterns: Iterable[re.Pattern[bytes]]) -> OutputTest:
    """The test that each of these patterns is found in the output."""
    return io.BytesIO(), _collate, _has_match, expected_patterns


def create_output_test_from_file(output_file: str) -> OutputTest:
    """The test of the lines of FILE.txt, else of the patterns of FILE.regex."""
    for extension in (".txt", ".regex"):
        if os.path.isfile(output_file + extension):
            with open(output_file + extension, "rb") as file:
                lines = file.read().splitlines()
            if extension == ".txt":
                return create_output_lines_test(lines)
            return create_output_regex_test([re.compile(line) for line in lines])
    raise RuntimeError(f"could not find output check file: {output_file}")


def _collate(output: Any, addendum: bytes) -> Any:
    output.write(addendum.replace(b"\r\n", b"\n"))
    return output


def _has_line(output: Any, part: bytes) -> bool:
    return any(part in line for line in output.getvalue().splitlines())


def _has_match(output: Any, pattern: re.Pattern[bytes]) -> bool:
    return pattern.search(output.getvalue()) is not None
