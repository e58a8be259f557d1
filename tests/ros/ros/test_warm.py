"""rclpy nodes that are forked behave as those that are executed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.posix import proc
from launcher.run.monitor.shared_memory import FOLDER, held
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain
from tests.support.waiting import wait_until

NODE = """#!{python}
import inspect
import os
import sys
import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

class Peer(Node):
    def __init__(self, name):
        super().__init__(name)
        self.publisher = self.create_publisher(String, "words", 10)
        self.create_subscription(String, "words", self.heard, 10)
        self.talking = self.create_timer(0.1, self.talk)
        self.known = set()

    def talk(self):
        if not os.path.exists("{silence}"):
            self.publisher.publish(String(data=self.get_name()))
            return
        self.publisher.publish(String(data=f"the end of {{self.get_name()}}"))
        self.talking.cancel()
        self.create_timer(1.0, lambda: None)  # a signal between two waits may not wake it otherwise

    def heard(self, message):
        if message.data not in self.known:
            self.known.add(message.data)
            print(self.get_name(), "hears", message.data, flush=True)

def unless_shut_down(spin):
    # an executor that is between two waits when the signal comes fails with an RCLError (one run
    # in ten beside busy loops), executed or forked; one that takes a message, with a RuntimeError
    # in place of the KeyboardInterrupt (ros2-behaviour.md, 4.24), so that they are silent by then
    try:
        spin()
    except RCLError:
        if rclpy.ok():
            raise

rclpy.init()
name = sys.argv[1]
print(name, "has found", len(inspect.modulesbyfile), "files", flush=True)
node = Peer(name)
if name == "careful":
    try:
        unless_shut_down(lambda: rclpy.spin(node))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    node.destroy_node()
    rclpy.try_shutdown()
elif name == "threads":
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    unless_shut_down(executor.spin)
    node.destroy_node()
    rclpy.try_shutdown()
else:
    try:
        rclpy.spin(node)
    finally:
        node.destroy_node()
"""
NAMES = ("careful", "threads", "plain")
# (node, signal) -> how its end is told, as of every rclpy node
ENDS = {
    ("careful", signal.SIGINT): "finished cleanly",
    ("careful", signal.SIGTERM): "finished cleanly",
    ("threads", signal.SIGTERM): "finished cleanly",
    ("threads", signal.SIGINT): "exit code -2",
    ("plain", signal.SIGINT): "exit code -2",
    ("plain", signal.SIGTERM): "exit code 1",
}
LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(executable="{script}", arguments=[name], name=None, output="screen", exec_name=name)
        for name in {names!r}
    ])
"""


class Run:
    """A run of the three nodes; `screen` is what it has written."""

    def __init__(self, folder: Path, env: dict[str, str], how: str) -> None:
        self.is_warm = how == "--warm"
        script, file = folder / "node", folder / "peers.launch.py"
        self.silence = folder / "silence"  # once it exists, the nodes publish nothing any more
        script.write_text(NODE.format(python=sys.executable, silence=self.silence))
        script.chmod(0o755)
        file.write_text(LAUNCH.format(script=script, names=NAMES))
        self._screen = folder / "screen"
        with open(self._screen, "wb") as screen:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "launcher", str(file), how, "--no-log-files"],
                env=env,
                cwd=REPOSITORY,
                stdout=screen,
                stderr=subprocess.STDOUT,
            )

    @property
    def screen(self) -> str:
        return self._screen.read_text(errors="replace")

    def pid_of(self, name: str) -> int:
        (pid,) = re.findall(rf"\[{name}-\d\]: process started with pid \[(\d+)\]", self.screen)
        return int(pid)

    def wait_for(self, text: str) -> None:
        wait_until(lambda: text in self.screen, f"{text!r} in\n{self.screen}")


@pytest.fixture(params=["--warm", pytest.param("--cold", marks=pytest.mark.thorough)])
def run(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Run]:
    with ros_domain(tmp_path / "log") as env:
        one = Run(tmp_path, env, request.param)
        yield one
        one.process.send_signal(signal.SIGINT)
        one.process.wait(60)


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_warm_nodes_talk_and_end_as_cold_ones(run: Run, signum: int):
    pairs = [(hearer, speaker) for hearer in NAMES for speaker in NAMES]
    for hearer, speaker in pairs:
        run.wait_for(f"{hearer} hears {speaker}")
    run.silence.touch()
    for hearer, speaker in pairs:
        run.wait_for(f"{hearer} hears the end of {speaker}")
    for name in NAMES:  # which rclpy does at the first message of the log
        (found,) = re.findall(rf"{name} has found (\d+) files", run.screen)
        assert (int(found) > 100) == run.is_warm
    pids = {run.pid_of(name) for name in NAMES}  # they have segments of other processes mapped, too
    wait_until(lambda: {proc.state(pid) for pid in pids} == {"S"}, "all of them wait for messages")
    segments = [Path(FOLDER, name) for name, pid in held().items() if pid in pids]
    segments = [path for path in segments if "_port" not in path.name]  # ports are shared
    assert len([path for path in segments if path.exists()]) >= len(NAMES)
    for name in NAMES:
        os.kill(run.pid_of(name), signum)
        run.wait_for(f"[{name}-{NAMES.index(name) + 1}]: process has")
        line = next(x for x in run.screen.splitlines() if f"[{name}-" in x and "process has" in x)
        assert ENDS[name, signal.Signals(signum)] in line
    assert [path for path in segments if path.exists()] == []
    assert "launcher/run/warm" not in run.screen
