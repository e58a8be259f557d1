"""Composable nodes under the launcher: no lost answer and no container makes it wait for ever.

The interfaces of containers have no wheel: tests/support/composition carries their fields.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.pytest_plugin import Launch
from tests.e2e.conftest import LONG_STOP, World

LOADING = re.compile("loading .")
INTERFACES = Path(__file__).parents[1] / "support/composition"

# What a container does with requests: `loses` the first answer, `dies` at the first request and
# works when it is started again.
CONTAINER = """
import os, sys, threading, time
import rclpy
from composition_interfaces.srv import ListNodes, LoadNode
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor

what, again = sys.argv[1], sys.argv[2]
rclpy.init()
node = rclpy.create_node("box")
nodes, requests, over = {}, [], threading.Event()

def load(request, response):
    requests.append(request)
    if what == "dies" and not os.path.exists(again):
        open(again, "w").close()
        os._exit(3)
    if what == "forgets" and len(requests) == 1:
        over.wait()
        return response
    nodes[len(nodes) + 1] = f"/{request.node_name}"
    if what == "works":
        loaded = rclpy.create_node(request.node_name, use_global_arguments=False)
        loaded.declare_parameter("speed_limit", 1.0)
        executor.add_node(loaded)
    node.get_logger().info(f"loading {request.node_name}")
    if what == "loses" and len(requests) == 1:
        over.wait()
    return response.put(success=True, full_node_name=f"/{request.node_name}", unique_id=len(nodes))

group = ReentrantCallbackGroup()
name = node.get_fully_qualified_name()
node.create_service(LoadNode, f"{name}/_container/load_node", load, callback_group=group)
node.create_service(
    ListNodes, f"{name}/_container/list_nodes", lambda _, answer: answer.put_nodes(nodes),
    callback_group=group)
try:
    executor = MultiThreadedExecutor(4)
    rclpy.spin(node, executor)
except (KeyboardInterrupt, ExternalShutdownException):
    over.set()
"""

LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess, LogInfo, RegisterEventHandler
from launch.event_handlers import OnShutdown
from launch_ros.actions import ComposableNodeContainer, LoadComposableNodes, Node
from launch_ros.descriptions import ComposableNode

def nodes(*names, **options):
    return [ComposableNode(package="p", plugin="P", name=name, **options) for name in names]

def box(name, what, **options):
    return ComposableNodeContainer(
        name=name, namespace="", executable="{folder}/box", arguments=[what, "{folder}/again"],
        output="screen", **options)

def generate_launch_description():
    return LaunchDescription([
        RegisterEventHandler(OnShutdown(on_shutdown=[LogInfo(msg="OnShutdown was called")])),
        {actions}])
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """Writes a launch file with containers, whose interfaces the launcher finds."""
    monkeypatch.setenv("PYTHONPATH", str(INTERFACES))
    (tmp_path / "box.py").write_text(CONTAINER)
    (tmp_path / "box").write_text(f'#!/bin/sh\nexec {sys.executable} {tmp_path}/box.py "$@"\n')
    (tmp_path / "box").chmod(0o755)

    def launch_file(actions: str) -> Path:
        file = tmp_path / "boxes.launch.py"
        file.write_text(LAUNCH.replace("{folder}", str(tmp_path)).replace("{actions}", actions))
        return file

    return launch_file


def test_nodes_are_loaded_though_answers_are_lost_and_containers_start_late_or_die(
    launched_system: Launch, write
):
    late = 'ExecuteProcess(cmd=["sleep", "2"], on_exit=[box("late", "works")])'
    file = write(f"""
        LoadComposableNodes(target_container="/late", composable_node_descriptions=nodes("a")),
        {late},
        box("loses", "loses", composable_node_descriptions=nodes("b", "c")),
        box("forgets", "forgets", composable_node_descriptions=nodes("d")),
        box("dies", "dies", respawn=True, composable_node_descriptions=nodes("e")),
        box("dead", "works", composable_node_descriptions=[]),
        LoadComposableNodes(target_container="invalid name",
                            composable_node_descriptions=nodes("f")),
    """)
    system = launched_system(file, **LONG_STOP)
    for name, box in (
        ("a", "late"),
        ("b", "loses"),
        ("c", "loses"),
        ("d", "forgets"),
        ("e", "dies"),
    ):
        system.wait_for_log("launch", f"Loaded node '/{name}' in container '/{box}'")
    system.wait_for_log("launch", "Failed to load node 'f'")
    ending = system.system.stop(150.0)
    loading = LOADING.findall("\n".join(system.logs("box-*")))
    assert sorted(loading) == [f"loading {name}" for name in "abcde"]  # none of them twice
    assert ending.left_processes == ()


def test_a_container_that_never_answers_ends_the_waiting(world: World, write):
    """Of this run: when its process has exited. Of another: after a time limit."""
    file = write("""
        box("gone", "dies", composable_node_descriptions=nodes("a", "b")),
        LoadComposableNodes(target_container="/nowhere", composable_node_descriptions=nodes("c")),
    """)
    program = (
        "import sys, launcher.engine.ros_requests as requests; requests.LOADING_LIMIT_S = 1.0; "
        "from launcher.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(file)],
        env={**world.env, "PYTHONPATH": str(INTERFACES)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    output = done.stdout
    for name in "ab":
        text = f"Failed to load node '{name}' of type 'P' in container '/gone': the process of"
        assert text in output
    assert "in container '/nowhere': /nowhere has not been there for 1 s" in output
    assert "OnShutdown was called" in output
    assert done.returncode == 1  # of the container


@pytest.mark.thorough
def test_a_loaded_node_may_not_declare_a_parameter_either(world: World, write):
    file = write("""
        box("box", "works", composable_node_descriptions=nodes(
            "a", parameters=[{"speed_limt": 1.0}])),
    """)
    with world.terminal(
        *world.command(str(file), "--no-console"),
        env={**world.env, "PYTHONPATH": str(INTERFACES)},
    ) as terminal:
        terminal.wait_for_all("[launch]: a: parameter 'speed_limt'", "did you mean 'speed_limit'?")
        terminal.ctrl_c()
        terminal.exit_code()
    assert re.search(rf"was set in {file}:\d+ but", terminal.text)
