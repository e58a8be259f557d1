"""The part of launch_testing that launch files load: markers and actions, without the tests."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable, Iterable, Iterator
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
    """Signals the test runner that the system is up; no-op without one."""

    def __init__(self) -> None:
        super().__init__()
        self.__callbacks: list[Callable[[], object]] = []

    def _add_callback(self, callback: Callable[[], object]) -> None:
        """Call this as well, once the action is executed: by ROS 2's name."""
        self.__callbacks.append(callback)

    def execute(self, context: Any) -> None:
        for callback in self.__callbacks:
            callback()


@public("launch_testing.util.keep_alive_process")
class KeepAliveProc(ExecuteProcess):
    """A process that does nothing until it is stopped."""

    def __init__(self) -> None:
        super().__init__(cmd=[sys.executable, "-c", _WAIT_SCRIPT])


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
