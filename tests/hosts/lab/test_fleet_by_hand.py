"""The fleet on three robots, as in docs/guides/robots.md: one is switched off."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from launcher.posix.domain_lease import leased_domain
from tests.support.hosts import Lab, Robot, needs_robots
from tests.support.hosts.operator import launcher_words
from tests.support.screen_terminal import ScreenTerminal

PLACES = {"robot_1": "bot1", "robot_2": "bot2", "robot_3": "bot3"}
Type = Callable[..., ScreenTerminal]


@pytest.fixture
def robots(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Robot]]:
    needs_robots()
    with leased_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        yield [lab.robot(name) for name in PLACES.values()]


@pytest.fixture
def operator_types(lab: Lab, tmp_path: Path) -> Iterator[Type]:
    """Runs the launcher with these words in a terminal of the operator."""
    terminals: list[ScreenTerminal] = []

    def begin(*words: object) -> ScreenTerminal:
        command = lab.operator.command(launcher_words(words), cwd=tmp_path)
        env = lab.operator.environment({"TERM": "xterm-256color"})
        terminals.append(ScreenTerminal(command, env=env, columns=140, rows=40))
        return terminals[-1]

    yield begin
    for terminal in terminals:
        terminal.__exit__()
    lab.operator.launcher("attach", "--hosts", tmp_path / "hosts.yaml", "--stop")


def test_three_robots_of_which_one_is_switched_off(
    lab: Lab, robots: list[Robot], operator_types: Type, tmp_path: Path
):
    lab.hosts_file(tmp_path / "hosts.yaml", robots, PLACES)

    check = operator_types("hosts", "check", "system", "--timeout", "60")
    assert check.exit_code() == 0, check.text

    run = operator_types("system", "--hosts", "hosts.yaml")
    run.wait_for("] on bot3", "Task pick_shelf_A3 complete", "Task deliver_dock_2 complete")
    run.enter("ps")
    run.wait_for("running  bot2")
    robots[1].power_off()
    run.wait_for("bot2 is unreachable")
    run.enter("ps")
    run.wait_until(lambda: re.search(r"robot_2-4 .*unreachable \d", run.text), "bot2 in ps")
    run.enter("detach")
    assert run.exit_code() == 0, run.text
    run.wait_for("robot_2-4 (bot2, unreachable)")
    run.wait_for("stopped, since they run here: dispatcher-1, monitor-2")
    assert sum("detached; these run on" in row for row in run.scrolled) == 1

    again = operator_types("attach", "--hosts", "hosts.yaml")
    again.wait_for("host 'bot2'", "[robot_1]: Task", "[robot_3]: Task")
    again.ctrl_c()
    assert again.exit_code() == 0, again.text
    for robot in (robots[0], robots[2]):
        listed = robot.run(["systemctl", "list-units", "--all", "--no-legend", "launcher*"])
        assert listed.stdout == ""
