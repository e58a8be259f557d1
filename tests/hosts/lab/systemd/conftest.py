"""A robot with systemd, and launchers whose processes are units there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.support.hosts import Lab, Robot, needs_robots
from tests.support.hosts.remote_run import RemoteRun

USERS = ("root", "robot")
SCREEN = "output='screen'"
COUNT = "n=0; while :; do n=$((n+1)); echo $n; sleep 0.1; done"


@pytest.fixture(scope="module")
def robot(lab: Lab) -> Robot:
    needs_robots()
    made = lab.robot("bot1")
    made.run(["loginctl", "enable-linger", "robot"])
    return made


@pytest.fixture(params=USERS)
def user(request: pytest.FixtureRequest) -> str:
    return str(request.param)


Start = Callable[..., RemoteRun]


@pytest.fixture
def start(lab: Lab, robot: Robot, tmp_path: Path) -> Iterator[Start]:
    """Starts a launcher on `(name, shell script, further arguments)` as a user of the robot.

    `options` are those of the launcher, `settings` entries of the host.
    """
    runs: list[RemoteRun] = []

    def begin(
        *processes: tuple[str, ...],
        user: str = "root",
        options: tuple[str, ...] = (),
        **settings: object,
    ) -> RemoteRun:
        host = {robot: {"user": user, "engine": "systemd", **settings}}
        lab.hosts_file(tmp_path / "hosts.yaml", host, {"*": robot.name})
        (tmp_path / "t.launch.py").write_text(launch_file(processes), encoding="utf-8")
        screen = tmp_path / f"screen{len(runs)}"
        run = RemoteRun(lab, screen, "t.launch.py", "--hosts", "hosts.yaml", *options)
        runs.append(run)
        return run

    yield begin
    for run in runs:
        run.__exit__(None, None, None)
    lab.operator.launcher("attach", "--hosts", tmp_path / "hosts.yaml", "--stop")
    leave_nothing(robot)


def leave_nothing(robot: Robot) -> None:
    """Of a test that has failed: the next ones name units by patterns."""
    for user in USERS:
        systemctl(robot, user, "stop", "launcher.slice")
        systemctl(robot, user, "reset-failed", "launcher*")
    robot.run(["rm", "-rf", "/run/launcher", "/run/user/1000/launcher"])


def launch_file(processes: tuple[tuple[str, ...], ...]) -> str:
    actions = "".join(
        f"ExecuteProcess(cmd=['/bin/sh', '-c', {script!r}], name={name!r}"
        f"{''.join(f', {one}' for one in (more or [SCREEN]))}), "
        for name, script, *more in processes
    )
    return (
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n"
        f"def generate_launch_description():\n    return LaunchDescription([{actions}])\n"
    )


def attach(lab: Lab, folder: Path, *words: str) -> RemoteRun:
    screen = folder / f"attached{len(list(folder.glob('attached*')))}"
    return RemoteRun(lab, screen, "attach", "--hosts", "hosts.yaml", *words)


def systemctl(robot: Robot, user: str, *words: str) -> str:
    manager = [] if user == "root" else ["--user", f"--machine={user}@"]
    return robot.run(["systemctl", *manager, *words], check=False).stdout


def restarts(robot: Robot, user: str, name: str) -> int:
    """How often systemd has restarted a process."""
    shown = systemctl(robot, user, "show", "-p", "NRestarts", f"launcher-*-{name}.service")
    return int(shown.strip().partition("=")[2] or 0)


def pid_there(robot: Robot, *words: str) -> int:
    """The pid of a process of the robot whose command line has these words."""
    for process in robot.processes():
        if all(any(word in one for one in process.words) for word in words):
            return process.pid
    return 0


def assert_no_traces(robot: Robot, user: str) -> None:
    assert systemctl(robot, user, "list-units", "--all", "--no-legend", "launcher*") == ""
    for folder in ("/run/launcher", "/run/user/1000/launcher"):
        assert robot.run(["test", "-e", folder], check=False).returncode == 1


def without_gap(numbers: list[int]) -> bool:
    return numbers == list(range(1, len(numbers) + 1))
