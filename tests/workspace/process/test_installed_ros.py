"""Without wheels, the launcher uses an installed ROS 2: of apt's layout, and of pixi's."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from launcher.packages.distribution import DEFAULT, or_default
from tests.support.ros_installation import Installation, PixiEnvironment, with_launcher
from tests.support.verbs import Answer, eventually
from tests.support.waiting import wait_until
from tests.workspace.unit.building.source_tree import interface_package, python_package, write

TIMEOUT_S = 300  # for a build
TALKER = """
import rclpy
from ball_msgs.msg import Ball

def main():
    rclpy.init()
    node = rclpy.create_node("thrower")
    publisher = node.create_publisher(Ball, "/ball", 10)
    node.create_timer(0.1, lambda: publisher.publish(Ball(radius=7)))
    rclpy.spin(node)
"""
LAUNCH = """
<launch>
  <node pkg="ball_nodes" exec="thrower" name="thrower"/>
</launch>
"""


@dataclass(frozen=True, slots=True)
class Shell:
    """A shell that has sourced the installation, in the folder of a workspace."""

    workspace: Path
    setup: Path | None
    python: Path
    prefix: Path

    def environment(self) -> dict[str, str]:
        passed = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOG_DIR")
        own = {"HOME": str(self.workspace.parent), "PYTHONNOUSERSITE": "1"}
        run = {"XDG_RUNTIME_DIR": os.environ["XDG_RUNTIME_DIR"], "PATH": "/usr/bin:/bin"}
        return {**{name: os.environ[name] for name in passed}, **own, **run}

    def popen(self, *words: str) -> subprocess.Popen[str]:
        source = f". {self.setup} && " if self.setup is not None else ""
        return subprocess.Popen(
            ["sh", "-c", f'{source}exec "$@"', "sh", str(self.python), "-m", "launcher", *words],
            env=self.environment(),
            cwd=self.workspace,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def launcher(self, *words: str) -> Answer:
        with self.popen(*words) as process:
            out, err = process.communicate(timeout=TIMEOUT_S)
        return Answer(out=out, err=err, code=process.returncode)


def sources() -> dict[str, str]:
    setup_py = (
        "from setuptools import setup\n"
        "setup(name='ball_nodes', version='0.0.0', packages=['ball_nodes'],\n"
        "  data_files=[('share/ament_index/resource_index/packages', ['resource/ball_nodes']),\n"
        "    ('share/ball_nodes', ['package.xml']),\n"
        "    ('share/ball_nodes/launch', ['launch/balls.launch.xml'])],\n"
        "  entry_points={'console_scripts': ['thrower = ball_nodes.thrower:main']})\n"
    )
    nodes = python_package("ball_nodes", "<exec_depend>ball_msgs</exec_depend>", setup_py=setup_py)
    return {
        **interface_package("ball_msgs", {"msg/Ball.msg": "int32 radius\n"}),
        **nodes,
        "ball_nodes/ball_nodes/__init__.py": "",
        "ball_nodes/ball_nodes/thrower.py": TALKER,
        "ball_nodes/launch/balls.launch.xml": LAUNCH,
    }


@pytest.fixture(scope="module", params=["apt", "pixi"])
def shell(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Shell]:
    """With a workspace that was built there."""
    folder = tmp_path_factory.mktemp(request.param)
    workspace = folder / "ws"
    write(workspace / "src", sources())
    if request.param == "apt":
        apt = Installation(folder / "root")
        found = Shell(workspace, apt.setup, with_launcher(folder / "env"), apt.prefix)
    else:
        pixi = PixiEnvironment(folder)
        found = Shell(workspace, pixi.setup, pixi.python, pixi.prefix)
    built = found.launcher("build")
    assert built.code == 0, built
    yield found
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="module")
def balls(shell: Shell) -> Iterator[Shell]:
    """The launch file of the workspace runs."""
    with shell.popen("ball_nodes", "balls.launch.xml") as running:
        wait_until(lambda: "/thrower" in shell.launcher("node", "list").out, "it is seen")
        yield shell
        running.terminate()
        out, err = running.communicate(timeout=TIMEOUT_S)
    assert running.returncode == 0, (out, err)


@pytest.mark.thorough
def test_it_is_named_and_nothing_is_wrong(shell: Shell):
    title = f"ROS 2 {or_default().title()}, from {shell.prefix}"
    found = shell.launcher("doctor", "--json")
    checks = {one["check"]: one for one in json.loads(found.out)["findings"]}

    assert f"({title})" in shell.launcher("--version").out
    assert (checks["ROS 2"]["level"], checks["ROS 2"]["text"]) == ("ok", title)
    assert [checks[name]["level"] for name in ("wheels", "library path")] == ["ok", "ok"], checks


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("topic", "echo", "/ball", "--once"), "radius: 7"),
        (("topic", "info", "/ball"), "Type: ball_msgs/msg/Ball"),
        (("interface", "show", "ball_msgs/msg/Ball"), "int32 radius"),
        (("param", "list", "/thrower"), "use_sim_time"),
    ],
)
def test_a_launch_and_verbs_about_it(balls: Shell, words: tuple[str, ...], expected: str):
    eventually(lambda: balls.launcher(*words), lambda answer: expected in answer.out)


@pytest.mark.thorough
def test_a_bag(balls: Shell, tmp_path: Path):
    bag = str(tmp_path / "bag")
    recorded = balls.launcher("bag", "record", "-o", bag, "/ball", "--for", "3")
    assert recorded.code == 0, recorded
    info = balls.launcher("bag", "info", bag)

    assert f"ROS Distro:        {or_default()}" in info.out
    assert "Type: ball_msgs/msg/Ball" in info.out, info


@pytest.mark.thorough
def test_run(shell: Shell):
    with shell.popen("run", "ball_nodes", "thrower") as node:
        wait_until(lambda: "/ball" in shell.launcher("topic", "list").out, "it is seen")
        node.terminate()
        node.communicate(timeout=TIMEOUT_S)


@pytest.mark.thorough
def test_without_ros_the_extra_is_named(shell: Shell, tmp_path: Path):
    if shell.python.is_relative_to(shell.prefix):
        pytest.skip("this Python has it")
    bare = Shell(shell.workspace.parent, None, shell.python, shell.prefix)

    balls = str(shell.workspace / "src/ball_nodes/launch/balls.launch.xml")
    asking = (
        *(("topic", "echo", "/a"), ("bag", "record", "-a"), ("foxglove",)),
        ("launch", balls, "--ros"),
        ("smoke", balls, "--record=e.yaml"),
    )
    for words in asking:
        found = bare.launcher(*words)
        assert (found.code, "Traceback" in found.err) == (2, False), found
        assert "source the setup file of ROS 2, or install its wheels: " in found.err
        assert f"launcher[{DEFAULT}]" in found.err
    for words in (("interface", "show", "a/msg/B"), ("tf", "tree"), ("interface", "list")):
        assert "there is no ROS 2: source the setup file of ROS 2" in bare.launcher(*words).err
    launched = bare.launcher(balls)
    assert "warning: there is no ROS 2 for nodes: source the setup file" in launched.err
    own = tmp_path / "own.launch.xml"
    node = tmp_path / "node.py"
    node.write_text("#!/usr/bin/env python3\nimport rclpy\n")
    node.chmod(0o755)
    own.write_text(f'<launch><node exec="{node}"/></launch>')
    launched = bare.launcher(str(own))
    assert "warning: there is no ROS 2 for nodes: source the setup file" in launched.err
    assert "(no ROS 2)" in bare.launcher("--version").out
