"""The interpreter of a run, as the engine sees it."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from launcher.base.model.events import ProcessExited, ProcessOutput, ProcessStarted
from launcher.language.actions.event_actions import LogInfo, RegisterEventHandler
from launcher.language.actions.process import ExecuteProcess, OnProcessStart
from launcher.language.compat import vocabulary
from launcher.language.description import LaunchDescription
from launcher.language.interpreter import Interpreter
from launcher.launch.launch_core import LaunchCore
from launcher.launch.target import LaunchRequest
from tests.language.unit.interpreter.interpreting import texts


@pytest.fixture
def core() -> Iterator[LaunchCore]:
    """Of a launch file that says `it runs` at each start of its process, number 1."""
    said = [LogInfo(msg="it runs")]
    description = LaunchDescription(
        [
            RegisterEventHandler(OnProcessStart(on_start=said)),
            ExecuteProcess(cmd=["true"], name="one"),
        ]
    )
    with vocabulary():
        interpreter = Interpreter(description)
        one = LaunchCore(interpreter, description, LaunchRequest("a.launch.py"))
        one.evaluate()
        one.start()
        yield one
        interpreter.close()


def adopt(core: LaunchCore, *started: int) -> None:
    """A reload after which these processes restart, whose start the launch file knows."""
    core.adopt(
        SimpleNamespace(  # type: ignore[arg-type]
            adopt=lambda old: None,
            interpreter=core.interpreter,
            description=None,
            started=set(started),
            plan_effects=[],
        )
    )


def test_the_start_of_a_container_that_a_reload_restarts_is_not_told_twice(core: LaunchCore):
    adopt(core, 1)
    core.handle(ProcessOutput(1, "stdout", b"the last words of the old one\n"))
    assert texts(core.handle(ProcessStarted(1, 7))) == []
    assert texts(core.handle(ProcessStarted(1, 8))) == ["it runs"]


def test_a_container_that_ends_before_has_its_next_start_told(core: LaunchCore):
    adopt(core, 1)
    core.handle(ProcessExited(1, 7, 1, will_restart=True))
    assert texts(core.handle(ProcessStarted(1, 8))) == ["it runs"]
