"""The fleet drill of docs/fleet.md, typed into the console of the real fleet."""

from __future__ import annotations

from tests.e2e.conftest import LONG_STOP_WORDS, REPOSITORY, World
from tests.support.drill import drill
from tests.support.screen_terminal import ScreenTerminal


def test_robot_2_is_killed_and_started_again_from_the_console(world: World):
    command = world.command("system", *LONG_STOP_WORDS)
    with ScreenTerminal(command, env=world.env, cwd=REPOSITORY, columns=140) as terminal:
        drill(terminal)
        terminal.enter("quit")
        assert terminal.exit_code() == 0, terminal.text
    assert world.survivors() == []
