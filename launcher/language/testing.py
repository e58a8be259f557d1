"""The part of launch_testing that launch files load: markers and actions, without the tests."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from launcher.language.action import Action
from launcher.language.actions.process import ExecuteProcess
from launcher.language.naming import public

_T = TypeVar("_T")

_WAIT_SCRIPT = (
    "import signal, threading; stop = threading.Event(); "
    "signal.signal(signal.SIGINT, lambda *a: stop.set()); "
    "signal.signal(signal.SIGTERM, lambda *a: stop.set()); stop.wait()"
)


@public("launch_testing.actions.ready")
class ReadyToTest(Action):
    """Tells the test runner that the system is up; without one there is nothing to tell."""

    def __init__(self) -> None:
        super().__init__()


@public("launch_testing.util.keep_alive_process")
class KeepAliveProc(ExecuteProcess):
    """A process that does nothing until it is stopped."""

    def __init__(self) -> None:
        super().__init__(cmd=[sys.executable, "-c", _WAIT_SCRIPT])


def keep_alive(test_description: _T) -> _T:
    """Mark a description: its system is not stopped by the end of the tests."""
    return test_description


def retry_on_failure(*, times: int, delay: float | None = None) -> Callable[[_T], _T]:
    """Mark a test: it is run again when it fails."""
    return lambda test: test


def post_shutdown_test() -> Callable[[_T], _T]:
    """Mark test cases: they run after the system was stopped."""
    return lambda test_case: test_case


def parametrize(argnames: Any, argvalues: Iterable[Any]) -> Callable[[_T], _T]:
    """Mark a description: it is made once for each set of values."""
    return lambda description: description
