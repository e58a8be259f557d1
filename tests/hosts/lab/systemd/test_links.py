"""Robots whose link, launcher or power is lost, and launchers that detach and attach."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from tests.hosts.lab.systemd.conftest import (
    COUNT,
    SCREEN,
    Start,
    assert_no_traces,
    attach,
    pid_there,
    restarts,
    systemctl,
    without_gap,
)
from tests.support.hosts import Lab, Robot
from tests.support.hosts.operator import launcher_words
from tests.support.waiting import wait_until


@pytest.mark.parametrize("victim", ["journalctl", "shell", "ssh", "sshd"])
def test_what_is_killed_is_made_again_and_no_line_is_lost(
    lab: Lab, robot: Robot, start: Start, victim: str
):
    run = start(("counter", COUNT))
    run.wait_for(r"\] 5$")
    if victim == "journalctl":
        pid = pid_there(robot, "journalctl", "--follow")
    elif victim == "shell":
        pid = next(one.pid for one in robot.processes() if one.words == ("sh",))
    elif victim == "ssh":
        pid = next(one.pid for one in lab.operator.processes() if "ControlMaster=auto" in one.words)
    else:
        robot.kill_sshd_sessions()
        pid = 0
    if pid:
        os.kill(pid, signal.SIGKILL)
    seen = len(run.numbers("counter-1"))
    wait_until(lambda: len(run.numbers("counter-1")) > seen + 60, "lines go on")
    assert run.interrupt() == 0
    assert without_gap(run.numbers("counter-1")), run.text


def test_nothing_is_lost_while_the_link_is_down(robot: Robot, start: Start, user: str):
    run = start(
        ("counter", COUNT), ("mad", "echo up; sleep 2; exit 1", SCREEN, "respawn=True"), user=user
    )
    run.wait_for(r"^\[counter-1\] 5$")
    robot.link_down()
    run.wait_for("bot1 is unreachable.*its processes run on")
    before = run.numbers("counter-1")[-1]
    wait_until(lambda: restarts(robot, user, "mad-2") >= 3, "it is restarted there")
    robot.link_up()
    run.wait_for("bot1 is reachable again")
    run.wait_for(rf"^\[counter-1\] {before + 60}$")
    assert run.interrupt() in (0, 130)
    assert without_gap(run.numbers("counter-1")), run.text
    assert "may be lost" not in run.text
    ups = run.text.count("[mad-2] up\n")
    assert ups == run.text.count("[mad-2]: process started")
    assert_no_traces(robot, user)


def test_a_slow_link_loses_nothing(robot: Robot, start: Start):
    robot.slow_link(delay_s=0.1, loss=0.02, bytes_per_s=200_000)
    try:
        run = start(("counter", COUNT), ("flood", "seq 3000; exec sleep 1000"))
        run.wait_for(r"^\[flood-2\] 3000$")
        run.wait_for(r"^\[counter-1\] 20$")
        assert run.interrupt() == 0, run.text
        assert run.numbers("flood-2") == list(range(1, 3001))
        assert without_gap(run.numbers("counter-1")), run.text
    finally:
        robot.normal_link()


def test_lines_that_the_journal_has_removed_meanwhile_are_told(robot: Robot, start: Start):
    run = start(("counter", COUNT))
    run.wait_for(r"^\[counter-1\] 5$")
    robot.link_down()
    run.wait_for("bot1 is unreachable")
    robot.run(["journalctl", "--rotate", "--vacuum-size=1"])
    robot.link_up()
    run.wait_for(
        "bot1: its journal was rotated before all was read: lines of processes may be lost"
    )
    run.wait_for("bot1 is reachable again")
    assert run.interrupt() == 0, run.text
    assert not without_gap(run.numbers("counter-1"))


def test_a_killed_launcher_leaves_units_that_can_be_stopped(
    lab: Lab, robot: Robot, start: Start, tmp_path: Path, user: str
):
    run = start(("counter", COUNT), user=user)
    run.wait_for(r"\] 3$")
    run.process.kill()
    run.process.wait()
    wait_until(lambda: not pid_there(robot, "journalctl", "--follow"), "its sessions end")
    assert pid_there(robot, COUNT)
    listed = lab.operator.launcher("attach", "--hosts", tmp_path / "hosts.yaml", "--list")
    assert "t.launch.py" in listed.stdout, listed.stderr
    stopped = lab.operator.launcher("attach", "--hosts", tmp_path / "hosts.yaml", "--stop")
    assert stopped.returncode == 0, stopped.stdout
    assert_no_traces(robot, user)


def test_detach_and_attach(lab: Lab, robot: Robot, start: Start, tmp_path: Path, user: str):
    run = start(("counter", COUNT, SCREEN, "respawn=True"), user=user)
    run.wait_for(r"\] 5$")
    assert lab.operator.launcher("detach").returncode == 0
    assert run.wait() == 0
    assert "these run on: counter-1 (bot1)" in run.text
    last = run.numbers("counter-1")[-1]
    with attach(lab, tmp_path, "-n", "500") as first, attach(lab, tmp_path) as second:
        first.wait_for("counter-1]: runs on bot1 with pid")
        second.wait_for("counter-1]: runs on bot1 with pid")
        first.wait_for(rf"\] {last + 20}$")
        assert without_gap(first.numbers("counter-1"))
        systemctl(robot, user, "kill", "--signal=KILL", "launcher-*-counter-1.service")
        for one in (first, second):
            one.wait_for("process started with pid")
        assert first.interrupt() == 0
        second.wait_for("root@operator has ended the run on bot1: shutting down")
        assert second.wait() == 0
    assert_no_traces(robot, user)


def test_a_run_that_is_stopped_by_another_operator_ends(
    lab: Lab, robot: Robot, start: Start, tmp_path: Path
):
    run = start(("counter", COUNT, SCREEN, "respawn=True"))
    run.wait_for(r"\] 3$")
    stopped = lab.operator.launcher("attach", "--hosts", tmp_path / "hosts.yaml", "--stop")

    assert stopped.returncode == 0, stopped.stdout
    assert run.wait() == 0
    assert "ended by: root@operator has ended the run on bot1" in run.text
    assert_no_traces(robot, "root")


def test_no_start_is_lost_by_a_detach(lab: Lab, robot: Robot, start: Start):
    run = start(("counter", COUNT, SCREEN), ("late", "echo begin; exec sleep 1000", SCREEN))
    run.wait_for(r"\] begin$")
    assert lab.operator.launcher("stop", "late").returncode == 0
    run.wait_for("late-2]: process was stopped|late-2]: process has finished")
    shell = next(one.pid for one in robot.processes() if one.words == ("sh",))
    os.kill(shell, signal.SIGSTOP)
    starting = lab.operator.popen(launcher_words(["start", "late"]))
    wait_until(lambda: "starting" in lab.operator.launcher("ps").stdout, "a start is requested")
    refused = lab.operator.launcher("detach")
    os.kill(shell, signal.SIGCONT)

    assert starting.wait(60) == 0
    assert "cannot detach from bot1: it has not got all requests yet" in refused.stderr
    run.wait_for("late-2]: process started", 2)
    wait_until(lambda: lab.operator.launcher("detach").returncode == 0, "it can be left")
    assert run.wait() == 0
    assert pid_there(robot, "sleep", "1000")


def test_without_the_launcher_the_robot_stops_its_processes(robot: Robot, start: Start, user: str):
    run = start(
        ("counter", COUNT, SCREEN, "respawn=True"), user=user, on_link_loss="stop-after=6 s"
    )
    run.wait_for(r"\] 40$")
    run.process.kill()
    run.process.wait()
    assert pid_there(robot, COUNT)
    wait_until(lambda: not pid_there(robot, COUNT), "the watch stops it")


def test_a_robot_without_power_is_unreachable_and_named(lab: Lab, start: Start, robot: Robot):
    run = start(("counter", COUNT))
    run.wait_for(r"\] 3$")
    robot.power_off()
    try:
        run.wait_for("bot1 is unreachable")
        assert run.interrupt() == 1
        assert "could not be reached: bot1 (counter-1)" in run.text
    finally:
        robot.power_on()
        lab.trust(robot)


def test_a_robot_that_was_restarted_is_used_again(lab: Lab, start: Start, robot: Robot):
    run = start(("counter", COUNT))
    run.wait_for(r"\] 3$")
    robot.power_off()
    run.wait_for("bot1 is unreachable")
    robot.power_on()
    lab.trust(robot)
    run.wait_for("bot1: was restarted; its processes are lost: counter-1")
    run.wait_for("bot1 is reachable again")
    assert run.wait() == 1  # nothing is left
    assert "first unexpected exit: counter-1 on bot1 (SIGKILL)" in run.text
    assert_no_traces(robot, "root")
