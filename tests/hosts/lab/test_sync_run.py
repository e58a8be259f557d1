"""A launch file runs on hosts from what `hosts sync` brought, by both engines."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.environments import environment_with_ros
from tests.support.hosts import Host, Lab
from tests.support.hosts.operator import launcher_words
from tests.support.hosts.requirements import needs_robots
from tests.support.sync_hosts import WORKSPACE
from tests.support.waiting import rest_of, wait_until
from tests.support.workspaces import BuiltWorkspace

NETWORK = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_DOMAIN_ID": "43"}


@pytest.fixture(scope="module")
def python(lab: Lab) -> str:
    """An environment with ROS and without the launcher, which hosts can see."""
    return str(environment_with_ros(lab.folder / "ros").python)


class Fleet:
    """The example: monitor and dispatcher here, the robots on hosts."""

    def __init__(self, lab: Lab, folder: Path, workspace: BuiltWorkspace, **hosts: Any) -> None:
        self._lab = lab
        self._folder = folder
        settings = {lab.hosts[name]: values for name, values in hosts.items()}
        first, second = hosts
        place = {"/robot_1": first, "/robot_2": second}
        self.file = lab.hosts_file(folder / "hosts.yaml", settings, place)
        self._workspace = f"--workspace={workspace.root}"

    def launcher(self, *words: object) -> subprocess.CompletedProcess[str]:
        done = self._lab.operator.run(
            launcher_words([*words, f"--hosts={self.file}", self._workspace]),
            check=False,
            cwd=self._folder,
            timeout=300,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done

    def run_until(self, *expected: str) -> str:
        """Start it, and stop it when all texts were printed; what it printed."""
        words = ["fleet_nodes", "fleet.launch.py", f"--hosts={self.file}", self._workspace]
        process = self._lab.operator.popen(
            launcher_words(words),
            cwd=self._folder,
            env=NETWORK,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        lines: list[str] = []
        assert process.stdout is not None
        for line in process.stdout:
            lines.append(line)
            if all(any(text in one for one in lines) for text in expected):
                process.send_signal(signal.SIGINT)
                break
        rest, _ = rest_of(process, 120)
        text = "".join([*lines, rest])
        assert process.returncode == 0, text
        return text


def is_idle(host: Host) -> bool:
    """Whether neither the agent nor a node runs there."""
    words = [word for process in host.processes() for word in process.words]
    return "launcher" not in words and not any("fleet_nodes" in word for word in words)


def test_robots_without_systemd(
    lab: Lab, python: str, fleet_workspace: BuiltWorkspace, tmp_path: Path
):
    names = ("one", "two")
    for name in names:
        lab.host(name)
    settings = {name: {"python": python, "engine": "ssh"} for name in names}
    fleet = Fleet(lab, tmp_path, fleet_workspace, **settings)
    fleet.launcher("hosts", "sync")

    text = fleet.run_until("[robot_1]: Executing task ", "[robot_2]: Executing task ")

    assert "exit code 0" in text
    for name in names:
        wait_until(lambda name=name: is_idle(lab.hosts[name]), f"nothing is left on {name}")
        assert (lab.hosts[name].home / WORKSPACE / "current/bin/python").is_file()


def test_the_check_uses_what_was_brought(
    lab: Lab, python: str, fleet_workspace: BuiltWorkspace, tmp_path: Path
):
    """Before, there is no launcher; afterwards, the packages of the plan are found."""
    lab.host("three")
    lab.host("four")
    settings = {name: {"python": python, "engine": "ssh"} for name in ("three", "four")}
    fleet = Fleet(lab, tmp_path, fleet_workspace, **settings)
    words = ["hosts", "check", "fleet_nodes", "fleet.launch.py", f"--hosts={fleet.file}"]
    words += ["--timeout", "60"]
    workspace = f"--workspace={fleet_workspace.root}"

    before = lab.operator.launcher(*words, workspace, cwd=tmp_path)
    fleet.launcher("hosts", "sync")
    after = lab.operator.launcher(*words, workspace, cwd=tmp_path)

    assert before.stdout.count(" has no launcher\n  -> python -m launcher hosts sync ") == 2
    assert before.returncode == 1
    assert after.stdout.count(" all found ") == 2, after.stdout
    assert after.stdout.endswith("\n2 hosts: no problem\n"), after.stdout


def test_robots_with_systemd(lab: Lab, fleet_workspace: BuiltWorkspace, tmp_path: Path):
    needs_robots()
    names = ("five", "six")
    for name in names:
        lab.robot(name)
    settings = {name: {"python": sys.executable, "engine": "systemd"} for name in names}
    fleet = Fleet(lab, tmp_path, fleet_workspace, **settings)
    fleet.launcher("hosts", "sync")

    text = fleet.run_until("[robot_1]: Executing task ", "[robot_2]: Executing task ")

    assert "exit code 0" in text
