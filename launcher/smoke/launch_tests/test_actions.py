"""Actions of tests: programs that are tests themselves, and a handler that waits for a text."""

from __future__ import annotations

import sys
from typing import Any

from launcher.language.actions.event_actions import OpaqueFunction
from launcher.language.actions.process import ExecuteProcess, OnProcessExit, OnProcessIO
from launcher.language.actions.timer import TimerAction
from launcher.language.naming import public


@public("launch_testing.actions.test")
class Test(ExecuteProcess):
    """A program that is a test; after `timeout` seconds it is interrupted."""

    __test__ = False  # for pytest

    def __init__(self, *, timeout: Any = None, kill_timeout: Any = 5.0, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__timeout = timeout

    @property
    def timeout(self) -> Any:
        return self.__timeout

    def execute(self, context: Any) -> Any:
        if isinstance(self.__timeout, int):  # which the timer would refuse as its own `period`
            kind, value = type(self).__name__, float(self.__timeout)
            raise TypeError(f"timeout of {kind} takes a float, as in ROS 2: write {value}")
        entities = super().execute(context)
        if not self.__timeout:
            return entities
        interrupt = OpaqueFunction(function=self._shutdown_process, kwargs={"send_sigint": True})
        timer = TimerAction(period=self.__timeout, actions=[interrupt])
        context.register_event_handler(
            OnProcessExit(target_action=self, on_exit=lambda *_: timer.cancel())
        )
        return [*(entities or ()), timer]


@public("launch_testing.actions.gtest")
class GTest(Test):
    """A program of GoogleTest."""

    def __init__(self, *, path: Any, **kwargs: Any) -> None:
        super().__init__(cmd=[path], **kwargs)
        self.__path = path

    @property
    def path(self) -> Any:
        return self.__path


@public("launch_testing.actions.pytest")
class PyTest(Test):
    """A file or folder of tests, run by pytest."""

    def __init__(self, *, path: Any, **kwargs: Any) -> None:
        super().__init__(cmd=[sys.executable, "-m", "pytest", path], **kwargs)
        self.__path = path

    @property
    def path(self) -> Any:
        return self.__path


@public("launch_testing.event_handlers.stdout_ready_listener")
class StdoutReadyListener(OnProcessIO):
    """Executes `actions` at each output of the process that has this text."""

    def __init__(self, *, target_action: Any = None, ready_txt: str, actions: Any) -> None:
        self.__text = ready_txt
        self.__actions = actions
        super().__init__(target_action=target_action, on_stdout=self.__written)

    def __written(self, event: Any) -> Any:
        return self.__actions if self.__text in event.text.decode(errors="replace") else None

    def describe(self) -> tuple[str, Any]:
        return super().describe()[0], self.__actions
