"""The part of launch_testing that launch files load: markers and actions, without the tests."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from launcher.language.action import Action
from launcher.language.actions.event_actions import EmitEvent, RegisterEventHandler
from launcher.language.actions.process import ExecuteProcess, OnProcessExit
from launcher.language.events.handlers import OnExecutionComplete
from launcher.language.events.launch import Shutdown
from launcher.language.naming import public

_T = TypeVar("_T")

_WAIT_SCRIPT = (
    "import signal, threading; stop = threading.Event(); "
    "signal.signal(signal.SIGINT, lambda *a: stop.set()); "
    "signal.signal(signal.SIGTERM, lambda *a: stop.set()); stop.wait()"
)


@public("launch_testing.actions.ready")
class ReadyToTest(Action):
    """Signals the test runner that the system is up; no-op without one."""

    def __init__(self) -> None:
        super().__init__()


@public("launch_testing.util.keep_alive_process")
class KeepAliveProc(ExecuteProcess):
    """A process that does nothing until it is stopped."""

    def __init__(self) -> None:
        super().__init__(cmd=[sys.executable, "-c", _WAIT_SCRIPT])


@public("launch_testing.legacy")
class LaunchTestService:
    """Shuts the system down when all tests have ended or a fixture process exits unexpectedly."""

    def __init__(self) -> None:
        self.__running: list[Action] = []
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

    def __test_passed(self, action: Action) -> Any:
        if action in self.__running:
            self.__running.remove(action)
        return [] if self.__running else _shutdown("all tests finished")

    def run(self, launch_service: Any, *args: Any, **kwargs: Any) -> int:
        """Run the service; its return code, or that of the last test that failed."""
        code: int = launch_service.run(*args, **kwargs)
        return self.__failed_with if code == 0 and self.__failed_with else code


def _shutdown(reason: str) -> list[EmitEvent]:
    return [EmitEvent(event=Shutdown(reason=reason))]


def keep_alive(test_description: _T) -> _T:
    """Mark a description: the system keeps running after the tests."""
    vars(test_description).setdefault("__markers__", {})["keep_alive"] = True
    return test_description


def retry_on_failure(*, times: int, delay: float | None = None) -> Callable[[_T], _T]:
    """Mark a test: it is repeated, after `delay` seconds, when an assertion of it fails.

    It is called `times` times at most.
    """
    if times <= 0:
        raise ValueError(f"times must be positive, not {times}")

    def mark(test: Any) -> Any:
        @functools.wraps(test)
        def repeated(*args: Any, **kwargs: Any) -> Any:
            for _ in range(times - 1):
                try:
                    return test(*args, **kwargs)
                except AssertionError:
                    time.sleep(delay or 0)
            return test(*args, **kwargs)

        return repeated

    return mark


def ready_to_test_action_timeout(timeout: float) -> Callable[[_T], _T]:
    """Mark a description: how long its ReadyToTest may take."""

    def mark(description: _T) -> _T:
        vars(description)["__ready_to_test_action_timeout__"] = timeout
        return description

    return mark


def post_shutdown_test() -> Callable[[_T], _T]:
    """Mark test cases: they run after the shutdown. TypeError for what is not a class."""

    def mark(test_case: object) -> Any:
        if not isinstance(test_case, type):
            raise TypeError("post_shutdown_test marks a class of tests, not a function")
        test_case.__post_shutdown_test__ = True  # type: ignore[attr-defined]
        return test_case

    return mark


def parametrize(argnames: Any, argvalues: Iterable[Any]) -> Callable[[Any], Any]:
    """Mark a description: called, it yields (description, arguments) for each set of values.

    `argnames` are names, or one text with commas; a single name takes values that are no tuples.
    """
    if isinstance(argnames, str):
        argnames = [name.strip() for name in argnames.split(",") if name.strip()]
        if len(argnames) == 1:
            argvalues = [v if isinstance(v, tuple) else (v,) for v in argvalues]
    sets = [dict(zip(argnames, values, strict=False)) for values in argvalues]

    def mark(description: Any) -> Any:
        @functools.wraps(description)
        def parametrized() -> Iterator[tuple[Any, dict[str, Any]]]:
            for arguments in sets:
                bound = functools.partial(description, **arguments)
                yield functools.update_wrapper(bound, description), arguments

        vars(parametrized)["__parametrized__"] = True
        return parametrized

    return mark
