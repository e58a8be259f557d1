"""Parameters that a node of the run does not declare are reported, and no others."""

from __future__ import annotations

import re
from pathlib import Path

import psutil
import pytest

from tests.support.children import children_with
from tests.support.waiting import wait_until
from tests.system.conftest import World

NODE = """
import sys
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

rclpy.init()
kind = sys.argv[1]
node = Node(kind, allow_undeclared_parameters=kind == "allows",
            automatically_declare_parameters_from_overrides=kind == "automatic",
            start_parameter_services=kind != "silent")
if kind in ("strict", "unnamed"):
    node.declare_parameter("task_duration_s", 1.0)
if kind == "late":
    node.create_timer(2.0, lambda: node.has_parameter("task_duration")
                      or node.declare_parameter("task_duration", 1.0))
print("ready", flush=True)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    node.destroy_node()
    rclpy.try_shutdown()
"""

LAUNCH = """
import sys
from launch import LaunchDescription
from launch_ros.actions import Node

def node(kind, **options):
    return Node(executable=sys.executable, arguments=["{folder}/node.py", kind], output="screen",
                parameters=[{{"task_duration": 2.0}}, *options.pop("more", [])], **options)

def generate_launch_description():
    return LaunchDescription([
        node("strict", name="strict", namespace="arm", more=["{folder}/some.yaml"]),
        node("unnamed"),
        node("allows", name="allows"),
        node("automatic", name="automatic"),
        node("late", name="late"),
        node("silent", name="silent"),
    ])
"""


@pytest.mark.thorough
def test_undeclared_parameters_are_reported_with_a_similar_name(world: World, tmp_path: Path):
    (tmp_path / "node.py").write_text(NODE)
    (tmp_path / "some.yaml").write_text("/arm/*:\n  ros__parameters:\n    task_durations: 1\n")
    file = tmp_path / "some.launch.py"
    file.write_text(LAUNCH.format(folder=tmp_path))

    terminal = world.launcher(str(file), "--no-console")
    terminal.wait_for_all("unnamed: parameter", "'task_durations'", "'task_duration'")
    wait_until(lambda: not helpers(terminal.pid), "the process that asks has ended")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    text = terminal.text
    found = re.findall(r"\[launch\]: (\S+): parameter '(\w+)' was set in (\S+) but .*; (.*)", text)
    meant = "did you mean 'task_duration_s'?"
    assert sorted(found) == [
        ("arm/strict", "task_duration", f"{file}:7", meant),
        ("arm/strict", "task_durations", f"{tmp_path}/some.yaml:3", meant),
        ("unnamed", "task_duration", f"{file}:7", meant),
    ]
    assert world.survivors() == []


OPTIONS = ((), ("--no-parameter-check",))


def helpers(launcher: int) -> list[psutil.Process]:
    return children_with(launcher, "launcher.ros.helpers.parameter_check")


@pytest.mark.thorough
def test_a_run_ends_while_its_nodes_are_asked_and_the_option_disables_it(
    world: World, tmp_path: Path
):
    file = tmp_path / "some.launch.py"
    (tmp_path / "node.py").write_text("import time; time.sleep(600)")  # never appears in ROS
    file.write_text(LAUNCH.format(folder=tmp_path))
    runs = {words: world.launcher(str(file), "--no-console", *words) for words in OPTIONS}
    asking, other = (terminal.pid for terminal in runs.values())
    for terminal in runs.values():
        terminal.wait_for("[launch]")
    wait_until(lambda: helpers(asking), "the nodes are asked")
    assert not helpers(other)
    for terminal in runs.values():
        terminal.ctrl_c()
        terminal.exit_code()
        assert "leftover" not in terminal.text
    assert world.survivors() == []
