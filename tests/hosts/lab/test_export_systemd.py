"""Exported units: systemd accepts them, and they run on a robot that was booted for the test."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.exports import ROBOTS, export, works
from tests.support.hosts import Lab, Robot, needs_robots
from tests.support.hosts.requirements import program
from tests.support.waiting import wait_until

ODD = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, TimerAction
from launch_ros.actions import Node

def generate_launch_description():
    words = ["echo", "100%", "%n $HOME ${HOME}", "a'b\\"c", "\\\\n;", "@x", "\\u00fc", "tab\\there"]
    return LaunchDescription([
        ExecuteProcess(cmd=words, name="\\u00d6dd/one (1)", additional_env={"P": "5% $X \\"'"}),
        ExecuteProcess(cmd=["echo $HOME; sleep 1"], shell=True, name="sshd"),
        Node(package="group_gp1", executable="robot_1", name="n" * 80, respawn=True,
             respawn_delay=0.5, parameters=[{"text": "a\\nb"}]),
        TimerAction(period=1.25, actions=[ExecuteProcess(cmd=["true"], name="late")]),
    ])
"""
OPTIONS = (
    *("--restart", "sshd=on-failure,max=3,window=60,backoff=0.5..30", "--nice", "late=5"),
    *("--cpus", "late=0", "--limit", "late:nofile=256,as=1G,core=0", "--user", "root"),
    *("--stop", "late=term:1,int:2"),
)


_UNITS = (".service", ".target", ".timer")


def verify(folder: Path) -> None:
    """Anything that systemd-analyze says is an error: of unknown keys it only warns."""
    if program("systemd-analyze") is None:
        pytest.skip("not installed: systemd-analyze")
    units = [str(one) for one in sorted(folder.iterdir()) if one.suffix in _UNITS]
    done = subprocess.run(
        ["systemd-analyze", "verify", *units],
        capture_output=True,
        text=True,
        timeout=60,
        env={"SYSTEMD_UNIT_PATH": f"{folder}:", "PATH": "/usr/bin:/bin"},
    )
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def test_systemd_accepts_the_units_of_the_fleet(tmp_path: Path):
    export("systemd", tmp_path / "out")
    verify(tmp_path / "out")


def test_systemd_accepts_odd_names_words_and_policies(tmp_path: Path):
    (tmp_path / "odd.launch.py").write_text(ODD)
    export("systemd", tmp_path / "out", *OPTIONS, target=tmp_path / "odd.launch.py")
    verify(tmp_path / "out")


def test_an_unknown_key_is_noticed(tmp_path: Path):
    export("systemd", tmp_path / "out")
    unit = tmp_path / "out" / "robot_1.service"
    unit.write_text(unit.read_text().replace("KillSignal=", "KilSignal="))
    with pytest.raises(AssertionError, match="KilSignal"):
        verify(tmp_path / "out")


@pytest.fixture(scope="module")
def robot(lab: Lab) -> Robot:
    needs_robots()
    return lab.robot("robot1")


@pytest.fixture(scope="module")
def installed(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The robot with the units of the fleet, by the commands of the README."""
    out = tmp_path_factory.mktemp("export") / "out"
    export("systemd", out, "--user", "robot", "--python", sys.executable)
    shutil.copytree(out, robot.root / "srv/out")
    install_as_told(robot, out / "README.md", "/srv/out")
    return robot


def install_as_told(robot: Robot, readme: Path, folder: str) -> None:
    """Run the commands of the README that install and start the units."""
    command = r"^(?:install|systemctl (?:daemon-reload|enable|start)).*$"
    install = re.findall(command, readme.read_text(), re.MULTILINE)
    robot.run(["sh", "-e", "-c", f"cd {folder}\n" + "\n".join(install)])


def journal(robot: Robot, unit: str) -> str:
    return robot.run(["journalctl", "-u", unit, "-o", "short-unix"]).stdout


def test_the_fleet_works_as_units(installed: Robot):
    wait_until(lambda: works(last_report(installed)), "all robots have finished tasks")
    users = installed.run(["systemctl", "show", "-p", "User", "robot_1"]).stdout
    assert users == "User=robot\n"


def last_report(robot: Robot) -> str:
    found = re.findall(r"Fleet report -- .*", journal(robot, "monitor"))
    return str(found[-1]) if found else ""


def test_the_timer_delayed_the_third_robot(installed: Robot):
    wait_until(lambda: started_s(installed, "robot_3"), "its timer has started it")
    started = {name: started_s(installed, name) for name in ROBOTS}
    assert started["robot_3"] - started["robot_1"] >= 4.9


def started_s(robot: Robot, unit: str) -> float:
    words = ["systemctl", "show", "-p", "ExecMainStartTimestampMonotonic", "--value", unit]
    return int(robot.run(words).stdout) / 1e6


def test_stopping_the_target_stops_all_in_order(installed: Robot):
    installed.run(["systemctl", "stop", "system.target"])
    for name in ("dispatcher", "monitor", *ROBOTS):
        wait_until(lambda name=name: state(installed, name)["ActiveState"] == "inactive", name)
        assert state(installed, name)["Result"] == "success"
        assert state(installed, name)["ExecMainStatus"] == "0"


def state(robot: Robot, unit: str) -> dict[str, str]:
    words = ["systemctl", "show", "-p", "ActiveState,Result,ExecMainStatus", unit]
    return dict(line.split("=", 1) for line in robot.run(words).stdout.split())


def test_the_units_come_back_with_the_robot(installed: Robot):
    installed.power_off()
    installed.power_on()
    wait_until(
        lambda: (
            installed.run(["systemctl", "is-active", "robot_3"], check=False).stdout == "active\n"
        ),
        "robot_3 was started by its timer",
    )


WORDS = ["100%", "%n $HOME ${HOME}", "a'b\"c", "\\n;", "@x", "\u00fc", "tab\there"]
TOLD = "5% $X \"'"
HERE = """
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node

SHOW = (
    "import os, sys; "
    "print([*sys.argv[1:], os.getcwd(), *(os.environ[n] for n in ('TOLD', 'TOKEN', 'SOURCED'))])"
)

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[PYTHON, "-c", SHOW, *WORDS], name="words",
                       additional_env={"TOLD": TOLD}),
        Node(package="group_gp1", executable="robot_1", name="told",
             parameters=[{"task_duration_s": 0.25}]),
        ExecuteProcess(cmd=["cat", get_package_share_directory("std_msgs") + "/package.xml",
                            get_package_share_directory("std_msgs")], name="shared"),
    ])
"""


def test_words_variables_and_files_arrive_as_they_are(robot: Robot, tmp_path: Path):
    """With a Python in the home, a file to source, and variables that only the host knows."""
    (tmp_path / "odd.launch.py").write_text(
        f"PYTHON, WORDS, TOLD = {(sys.executable, WORDS, TOLD)!r}\n{HERE}"
    )
    (tmp_path / "hosts.yaml").write_text(
        "hosts: {bot: {address: 10.0.0.2, user: robot, python: my env/bin/python,"
        " setup: [my set-up.sh], environment: {TOKEN: hush}}}\nplace: {'*': bot}\n"
    )
    hosts = ("--hosts", str(tmp_path / "hosts.yaml"))
    export("systemd", tmp_path / "out", *hosts, target=tmp_path / "odd.launch.py")
    verify(tmp_path / "out" / "bot")
    shutil.copytree(tmp_path / "out" / "bot", robot.root / "srv/odd")
    (robot.root / "srv/odd/odd.env").write_text("TOKEN=a secret\n")
    (robot.root / "home/robot/my set-up.sh").write_text("export SOURCED=1\n")
    (robot.root / "home/robot/my env").symlink_to(sys.prefix)
    install_as_told(robot, tmp_path / "out" / "README.md", "/srv/odd")
    wait_until(lambda: "a secret" in journal(robot, "words"), "the words are printed")
    (shown,) = re.findall(r": (\[.*\])$", journal(robot, "words"), re.MULTILINE)
    assert ast.literal_eval(shown) == [*WORDS, "/home/robot", TOLD, "a secret", "1"]
    wait_until(lambda: "<name>std_msgs</name>" in journal(robot, "shared"), "the file is printed")
    wait_until(lambda: "Is a directory" in journal(robot, "shared"), "the folder is found")
    wait_until(lambda: state(robot, "told")["ActiveState"] == "active", "the node runs")
    assert robot.run(["cat", "/etc/launcher/odd/files/told.params.yaml"]).stdout
    robot.run(["systemctl", "stop", "odd.target"])
