"""Robots of the lab: real systemd, for root and for a user, and nothing left of it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.support.hosts import Lab, Robot, leftovers, needs_robots
from tests.support.hosts.checks import answers, heard, is_reached, killed_run, login, traces
from tests.support.waiting import wait_until

MANAGERS = (("root", "--system"), ("robot", "--user"))


@pytest.fixture(scope="module")
def robot(lab: Lab) -> Robot:
    needs_robots()
    return lab.robot("robot1")


def test_a_robot_has_booted_without_a_failed_service(robot: Robot):
    wait_until(
        lambda: robot.run(["systemctl", "is-system-running"], check=False).stdout == "running\n",
        "all is started",
    )
    assert robot.run(["systemctl", "--failed", "--quiet"]).stdout == ""
    assert robot.run(["hostname"]).stdout == "robot1\n"


@pytest.mark.parametrize(("user", "manager"), MANAGERS)
def test_systemd_runs_commands_and_returns_their_exit_codes(
    lab: Lab, robot: Robot, user: str, manager: str
):
    run = f"systemd-run {manager} --wait --pipe --quiet sh -c 'id -un; exit 3'"
    done = login(lab, robot, run, user=user)
    assert (done.stdout, done.returncode) == (f"{user}\n", 3), done.stderr


@pytest.mark.parametrize(("user", "manager"), MANAGERS)
def test_a_unit_outlives_the_session_and_its_lines_are_in_the_journal(
    lab: Lab, robot: Robot, user: str, manager: str
):
    run = f"systemd-run {manager} --unit=lab-{user} sh -c 'echo begun; exec sleep 1000'"
    assert login(lab, robot, run, user=user).returncode == 0
    kind = "--unit" if user == "root" else "--user-unit"
    read = f"journalctl {kind}=lab-{user} -o cat"
    wait_until(lambda: "begun\n" in login(lab, robot, read, user=user).stdout, "a line")
    unit = f"systemctl {manager} is-active lab-{user}; systemctl {manager} stop lab-{user}"
    assert login(lab, robot, unit, user=user).stdout == "active\n"


@pytest.mark.parametrize("user", ["root", "robot"])
def test_each_user_has_the_environment_of_the_tests(lab: Lab, robot: Robot, user: str):
    code = "import launcher, rclpy; print(launcher.__file__)"
    done = login(lab, robot, f"{sys.executable} -c '{code}'", user=user)
    assert Path(done.stdout.strip()).is_file(), done.stderr


def test_robots_are_apart_from_each_other_and_find_nodes_of_each_other(lab: Lab, robot: Robot):
    second = lab.robot("robot2")
    for path in ("/dev/shm", "/tmp", "/run", "/root", "/etc"):
        robot.run(["touch", f"{path}/mark"])
        assert second.run(["test", "-e", f"{path}/mark"], check=False).returncode == 1
    ids = {computer.run(["cat", "/etc/machine-id"]).stdout for computer in (robot, second)}
    assert len(ids) == 2
    assert heard(robot, second) >= 0


def test_a_robot_without_power_boots_again_with_its_files(lab: Lab):
    needs_robots()
    robot = lab.robot("dark")
    login(lab, robot, "echo kept > note", user="robot")
    robot.power_off()
    assert robot.processes() == []
    assert not is_reached(lab, robot)
    robot.power_on()
    wait_until(lambda: is_reached(lab, robot), "the robot answers again")
    assert login(lab, robot, "cat note", user="robot").stdout == "kept\n"


def test_a_changed_host_key_of_a_robot_is_refused(lab: Lab, robot: Robot):
    robot.new_host_key()
    assert "Host key verification failed" in login(lab, robot, "true").stderr
    lab.trust(robot)
    assert answers(lab, robot)


def test_nothing_is_left_of_a_robot():
    needs_robots()
    with Lab() as lab:
        lab.robot("gone")
        assert len(traces(lab.name)) > 5
    assert traces(lab.name) == []


def test_the_next_lab_removes_the_robot_of_a_killed_run():
    needs_robots()
    with killed_run("robot") as (name, left):
        assert len(left) > 5
        leftovers.remove_leftovers()
        assert traces(name) == []
