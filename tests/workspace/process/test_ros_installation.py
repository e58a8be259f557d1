"""A host with an installation of ROS 2, as in /opt/ros, needs only the launcher."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from launcher.hosts.sync.synced_packages import collect
from tests.support.ros_installation import Installation
from tests.support.sync_hosts import PLAIN_PYTHON, Site, pinned
from tests.support.verbs import Answer
from tests.support.waiting import rest_of, wait_until

TIMEOUT_S = 60


class RosHost:
    """The launcher was brought there by `hosts sync`; a shell has sourced the installation."""

    def __init__(self, folder: Path) -> None:
        self.installation = Installation(folder / "root")
        setup = (str(self.installation.setup),)
        self.site = Site(folder / "bot", python=PLAIN_PYTHON, setup=setup)
        # A list of packages is given, and no environment is made of it.
        self.site.sync(collect(None), requirements=pinned("ros-rclpy==7.1.6"))

    def command(self, *words: str) -> list[str]:
        script = f'. {self.installation.setup} && exec "$@"'
        return ["sh", "-c", script, "sh", str(self.site.current / "bin/python"), *words]

    def popen(self, *words: str, **options: Any) -> subprocess.Popen[str]:
        return subprocess.Popen(
            self.command(*words),
            env=self.environment(),
            cwd=self.site.home,
            stdin=subprocess.DEVNULL,
            text=True,
            **options,
        )

    def environment(self) -> dict[str, str]:
        passed = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOG_DIR")
        kept = {name: os.environ[name] for name in passed}
        runtime = self.site.home / "run"
        runtime.mkdir(mode=0o700, exist_ok=True)
        own = {"HOME": str(self.site.home), "XDG_RUNTIME_DIR": str(runtime)}
        return {**kept, **own, "PATH": "/usr/bin:/bin", "PYTHONNOUSERSITE": "1"}

    def run(self, *words: str) -> Answer:
        with self.popen(*words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            out, err = process.communicate(timeout=TIMEOUT_S)
        return Answer(out=out, err=err, code=process.returncode)

    def launcher(self, *words: str) -> Answer:
        return self.run("-m", "launcher", *words)


@pytest.fixture(scope="module")
def ros_host(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosHost]:
    folder = tmp_path_factory.mktemp("ros")
    yield RosHost(folder)
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def monitor(ros_host: RosHost) -> Iterator[None]:
    """A node of a package that was brought."""
    words = ("-m", "launcher", "run", "group_gp1", "monitor")
    with ros_host.popen(*words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as node:
        try:
            wait_until(lambda: "/monitor" in ros_host.launcher("node", "list").out, "it is seen")
            yield
        finally:
            node.terminate()


@pytest.mark.thorough
def test_nothing_of_pip_is_used(ros_host: RosHost):
    code = (
        "import sys, rclpy, launcher\n"
        "from importlib import metadata\n"
        "names = {d.metadata['Name'] for d in metadata.distributions()}\n"
        "print(rclpy.__file__, launcher.__file__, sys.prefix == sys.base_prefix)\n"
        "print([name for name in names if name.startswith('ros-') or name == 'psutil'])\n"
    )
    lines = ros_host.run("-c", code).out.splitlines()

    rclpy, launcher, is_plain = lines[0].split()
    assert rclpy.startswith(str(ros_host.installation.prefix))
    assert launcher.startswith(str(ros_host.site.workspace))
    assert (is_plain, lines[1]) == ("True", "[]")
    assert list((ros_host.site.workspace / "venvs").iterdir()) == []


def test_packages_of_the_installation_and_those_that_were_brought_are_found(ros_host: RosHost):
    code = (
        "import os\n"
        "from launcher.packages.finder import package_prefix\n"
        "for name in ('rclpy', 'std_msgs'): print(package_prefix(name, os.environ))\n"
    )
    done = ros_host.run("-c", code)
    plan = ros_host.launcher("plan", "group_gp1", "system.launch.py")

    assert set(done.out.split()) == {str(ros_host.installation.prefix)}, done.err
    assert plan.code == 0, plan.err
    assert f"$ {ros_host.site.current.resolve()}/install/lib/group_gp1/dispatcher" in plan.out


@pytest.mark.usefixtures("monitor")
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("topic", "echo", "/fleet/report", "--once"), "data: 'Fleet report"),
        (("interface", "show", "geometry_msgs/msg/Twist"), "Vector3"),
        *(
            pytest.param(words, expected, marks=pytest.mark.thorough)
            for words, expected in [
                (("topic", "list"), "/fleet/report"),
                (("topic", "info", "/fleet/report", "-v"), "Reliability: RELIABLE"),
                (("topic", "type", "/fleet/report"), "std_msgs/msg/String"),
                (("node", "info", "/monitor"), "/fleet/status: std_msgs/msg/String"),
                (("service", "list", "-t"), "/monitor/list_parameters"),
                (("param", "list", "/monitor"), "use_sim_time"),
                (("graph",), "/monitor"),
                (("doctor",), "ok"),
            ]
        ),
    ],
)
def test_verbs_about_ros_work(ros_host: RosHost, words: tuple[str, ...], expected: str):
    answers: list[Answer] = []

    def is_expected() -> bool:
        answers.append(ros_host.launcher(*words))
        return expected in answers[-1].out

    wait_until(is_expected, f"{words} prints {expected}")
    assert "Traceback" not in answers[-1].err


@pytest.mark.thorough
def test_the_fleet_runs_with_a_console_that_cannot_start(ros_host: RosHost):
    words = ("-m", "launcher", "group_gp1", "system.launch.py")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    lines: list[str] = []
    with ros_host.popen(*words, **pipes) as process:
        assert process.stdout is not None
        for line in process.stdout:
            lines.append(line)
            if re.search(r"robot_1: [1-9]\d* tasks", line):
                break
        process.send_signal(signal.SIGINT)
        lines.append(rest_of(process, TIMEOUT_S)[0])
    assert process.returncode == 0, "".join(lines)
    assert "exit code 0: " in lines[-1], "".join(lines)


def test_a_verb_that_needs_a_package_that_is_missing_says_so(ros_host: RosHost):
    done = ros_host.launcher("runs")

    if done.code:  # this machine's Python may have it
        assert "this needs the Python package 'rich', which " in done.err
        assert "apt install python3-rich" in done.err
        assert "Traceback" not in done.err


def test_without_the_setup_file_it_is_named(ros_host: RosHost):
    done = subprocess.run(
        [
            str(ros_host.site.current / "bin/python"),
            "-m",
            "launcher",
            "topic",
            "pub",
            "/a",
            "std_msgs/String",
        ],
        env=ros_host.environment(),
        cwd=ros_host.site.home,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )

    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "source the setup file of ROS 2" in done.stderr
