"""The console of the real fleet: the drill of docs/guides/fleet.md, and the picker."""

from __future__ import annotations

import signal
from collections.abc import Callable

import pytest

from tests.support.console_scenes import drill, picker, picker_log
from tests.support.repository import REPOSITORY
from tests.support.screen_terminal import ScreenTerminal
from tests.system.conftest import LONG_STOP_WORDS, World


@pytest.mark.parametrize(
    ("scene", "columns"),
    [
        pytest.param(drill, 80, id="drill-80", marks=pytest.mark.thorough),
        pytest.param(drill, 120, id="drill-120", marks=pytest.mark.thorough),
        pytest.param(picker, 120, id="picker-120", marks=pytest.mark.thorough),
        pytest.param(picker_log, 80, id="picker-log-80", marks=pytest.mark.thorough),
    ],
)
def test_the_fleet_is_controlled_from_its_console(
    world: World, scene: Callable[[ScreenTerminal], None], columns: int
):
    command = world.command("system", *LONG_STOP_WORDS)
    with ScreenTerminal(command, env=world.env, cwd=REPOSITORY, columns=columns) as terminal:
        scene(terminal)
        terminal.kill(signal.SIGINT)
        assert terminal.exit_code() == 0, terminal.text
        assert not terminal.cursor_is_hidden
        assert terminal.settings() == terminal.untouched
    assert world.survivors() == []
