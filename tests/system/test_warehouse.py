"""Many robots of one class under the launcher: `launch/warehouse.launch.py`."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable

import pytest

from tests.support.terminal import Terminal, marked_processes
from tests.support.verbs import eventually, launcher
from tests.system.conftest import MARK, World

EIGHT = [f"robot_{number:03}" for number in range(1, 9)]


def wait_for_a_report(terminal: Terminal, fact: Callable[[str], object]) -> None:
    """Read until the monitor reports this, for a hundred reports at most."""
    for _ in range(100):
        terminal.wait_for("Fleet report -- ")
        terminal.wait_for("\r\n")
        if fact(terminal.text.rpartition("Fleet report -- ")[2]):
            return
    raise AssertionError(f"no such report:\n{terminal.text}")


def has_all(report: str) -> bool:
    """Whether the report counts a task of each."""
    return all(re.search(rf"{one}: [1-9]", report) for one in EIGHT)


def pid_of(world: World, node: str) -> int:
    """The process of a node."""
    found = [
        process.pid
        for command, process in marked_processes(MARK, world.mark).items()
        if f"__node:={node}" in command.split()
    ]
    (pid,) = found
    return pid


@pytest.mark.thorough
def test_eight_robots_work_and_a_killed_one_is_named_and_left_out(world: World):
    terminal = world.launcher("warehouse", "robots:=8", "task_period:=4")
    wait_for_a_report(terminal, has_all)

    os.kill(pid_of(world, "robot_003"), signal.SIGKILL)
    terminal.wait_for_all(
        "[monitor]: robot_003 has not reported in ",
        "[dispatcher]: robot_003 has not reported in ",
    )
    silent = len(terminal.text)
    for _ in range(14):  # two rounds
        terminal.wait_for(": Assigned task ")
        terminal.wait_for("\r\n")

    later = terminal.text[silent:]
    assert "to robot_003" not in later and "to robot_004" in later
    terminal.ctrl_c()
    assert terminal.exit_code() == 130, terminal.text  # one had died
    assert "Traceback" not in terminal.text
    assert world.survivors() == []


@pytest.mark.thorough
def test_forty_robots_work_through_a_discovery_server_and_the_next_dispatcher_goes_on(
    world: World,
):
    world.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
    terminal = world.launcher(
        "warehouse", "robots:=40", "task_period:=10", "output:=own_log", "--discovery", "server"
    )

    def all_work(report: str) -> bool:
        fewest = re.search(r"fewest tasks: (\d+)", report)
        return " 0 not started" in report and fewest is not None and int(fewest[1]) >= 1

    wait_for_a_report(terminal, all_work)
    assert "find each other" not in terminal.text
    # Verbs in other shells have the server from the run.
    eventually(lambda: launcher(world.env, "node", "list"), lambda answer: len(answer.lines) == 42)
    eventually(
        lambda: launcher(world.env, "topic", "info", "/fleet/tasks"),
        lambda answer: "Subscription count: 40" in answer.out,
    )

    assert launcher(world.env, "restart", "dispatcher").code == 0
    started = len(terminal.text)
    terminal.wait_for("; 40 of 40 robots report")
    account = terminal.text[started:].rpartition("Dispatched ")[2]
    assert int(account.split()[0]) > 0
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text
    assert "Traceback" not in terminal.text
    assert world.survivors() == []
