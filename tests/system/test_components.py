"""Composable nodes under the launcher: no lost answer and no container makes it wait for ever.

The services of containers have no wheel: they are built in a workspace.
"""

from __future__ import annotations

import re
import subprocess
import sys
from ast import literal_eval
from pathlib import Path

import pytest

from launcher.smoke.pytest_plugin import Launch
from tests.support.repository import REPOSITORY
from tests.support.workspaces import built_once
from tests.system.conftest import LONG_STOP, World

LOADING = re.compile("loading ([a-f])")
PACKAGES = REPOSITORY / "tests/support/composition"

# What a container does with requests: `loses` the first answer, `dies` at the first request and
# works when it is started again.
CONTAINER = """
import os, sys, threading
import rclpy
from composition_interfaces.srv import ListNodes, LoadNode, UnloadNode
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.parameter import parameter_value_to_python
from std_msgs.msg import String

what, again = sys.argv[1], sys.argv[2]
rclpy.init()
node = rclpy.create_node("box")
nodes, requests, over = {}, [], threading.Event()

def values(parameters):
    return {one.name: parameter_value_to_python(one.value) for one in parameters}

def load(request, response):
    requests.append(request)
    if what == "dies" and not os.path.exists(again):
        open(again, "w").close()
        os._exit(3)
    if what == "forgets" and len(requests) == 1:
        over.wait()
        return response
    if request.plugin_name == "Unknown":
        response.error_message = "no plug-in Unknown in package p"
        return response
    namespace = request.node_namespace.rstrip("/")
    unique_id, name = len(requests), f"{namespace}/{request.node_name or 'of_plugin'}"
    nodes[unique_id] = name
    if request.plugin_name == "Leaves":
        threading.Timer(1.0, os._exit, [0]).start()
    elif what == "works":
        arguments = [word for rule in request.remap_rules for word in ("-r", rule)]
        make = LifecycleNode if request.plugin_name == "Pump" else rclpy.create_node
        loaded = make(
            request.node_name or "of_plugin", namespace=request.node_namespace or None,
            cli_args=["--ros-args", *arguments], use_global_arguments=False)
        loaded.declare_parameter("speed_limit", 1.0)
        loaded.create_publisher(String, "out", 1)
        loaded.create_publisher(String, "state", 1)
        executor.add_node(loaded)
    node.get_logger().info(f"loading {name[1:]}")
    print("PARAMETERS", values(request.parameters), flush=True)
    print("EXTRA", values(request.extra_arguments), flush=True)
    if what == "loses" and len(requests) == 1:
        over.wait()
    response.success, response.full_node_name, response.unique_id = True, name, unique_id
    return response

def unload(request, response):
    response.success = nodes.pop(request.unique_id, None) is not None
    return response

def names(request, response):
    response.unique_ids, response.full_node_names = list(nodes), list(nodes.values())
    return response

group = ReentrantCallbackGroup()
for kind, name, answer in (
    (LoadNode, "load_node", load), (UnloadNode, "unload_node", unload),
    (ListNodes, "list_nodes", names),
):
    service = f"{node.get_fully_qualified_name()}/_container/{name}"
    node.create_service(kind, service, answer, callback_group=group)
try:
    executor = MultiThreadedExecutor(4)
    rclpy.spin(node, executor)
except (KeyboardInterrupt, ExternalShutdownException):
    over.set()
"""

LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess, LogInfo, OpaqueFunction, RegisterEventHandler
from launch.conditions import IfCondition
from launch.event_handlers import OnShutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import (
    ComposableNodeContainer, LoadComposableNodes, Node, SetParameter, SetRemap)
from launch_ros.descriptions import ComposableLifecycleNode, ComposableNode
from launch_ros.event_handlers import OnStateTransition

pump = ComposableLifecycleNode(
    package="p", plugin="Pump", name="pump", namespace="site", autostart=True)

def has_a_time(context):
    event = context.locals.event
    return [LogInfo(msg=f"time {event.timestamp > 1e18} {event.stamp.sec > 1e9}")]

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


@pytest.fixture(scope="session")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(built_once(tmp_path_factory.getbasetemp(), "composition", PACKAGES).root)


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workspace: str) -> object:
    """Writes a launch file with containers; the launcher finds the workspace by its variable."""
    monkeypatch.setenv("LAUNCHER_WORKSPACE", workspace)
    (tmp_path / "box.py").write_text(CONTAINER)
    (tmp_path / "box").write_text(f'#!/bin/sh\nexec {sys.executable} {tmp_path}/box.py "$@"\n')
    (tmp_path / "box").chmod(0o755)

    def launch_file(actions: str) -> Path:
        file = tmp_path / "boxes.launch.py"
        file.write_text(LAUNCH.replace("{actions}", actions).replace("{folder}", str(tmp_path)))
        return file

    return launch_file


@pytest.mark.thorough
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
    assert sorted(loading) == [*"abcde"]  # none of them twice
    assert ending.left_processes == ()


@pytest.mark.thorough
def test_a_container_that_never_answers_ends_the_waiting(world: World, write, workspace: str):
    """Of this run: when its process has exited. Of another: after a time limit."""
    file = write("""
        box("gone", "dies", composable_node_descriptions=nodes("a", "b")),
        LoadComposableNodes(target_container="/nowhere", composable_node_descriptions=nodes("c")),
        box("leaves", "works", composable_node_descriptions=[ComposableLifecycleNode(
            package="p", plugin="Leaves", name="left", autostart=True)]),
    """)
    program = (
        "import sys, launcher.run.ros_requests as requests; requests.LOADING_LIMIT_S = 1.0; "
        "from launcher.cli.dispatch import main; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(file)],
        env={**world.env, "LAUNCHER_WORKSPACE": workspace},
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
    assert "Failed to make transition 'TRANSITION_CONFIGURE' for LifecycleNode '/left'" in output
    assert "OnShutdown was called" in output
    assert done.returncode == 1  # of the container


@pytest.mark.thorough
def test_a_loaded_node_may_not_declare_a_parameter_either(world: World, write, workspace: str):
    file = write("""
        box("box", "works", composable_node_descriptions=nodes(
            "a", parameters=[{"speed_limt": 1.0}])),
    """)
    with world.terminal(
        *world.command(str(file), "--no-console"),
        env={**world.env, "LAUNCHER_WORKSPACE": workspace},
    ) as terminal:
        terminal.wait_for_all("[launch]: a: parameter 'speed_limt'", "did you mean 'speed_limit'?")
        terminal.ctrl_c()
        terminal.exit_code()
    assert re.search(rf"was set in {file}:\d+ but", terminal.text)


@pytest.mark.thorough
def test_a_request_carries_everything_that_the_launch_file_says(launched_system: Launch, write):
    file = write("""
        SetParameter("of_all", 7),
        SetRemap("state", "state_of_all"),
        box("box", "works", composable_node_descriptions=[
            ComposableNode(
                package="p", plugin="P", name="a", namespace="arm",
                parameters=["{folder}/some.yaml", {
                    "b": True, "i": -1, "f": 0.5, "s": "\u00fc", "y": b"ab", "speed_limit": 2.0,
                    "bs": [True, False], "is": [1, 2], "fs": [1.5], "ss": ["x", "y"],
                    "deep": {"er": LaunchConfiguration("x", default="3")}}],
                remappings=[("out", "to")],
                extra_arguments=[{"use_intra_process_comms": True}]),
            ComposableNode(package="p", plugin="Unknown", name="u"),
            ComposableNode(package="p", plugin="P", name="v", condition=IfCondition("false")),
            ComposableNode(package="p", plugin="P", name="w", parameters=[{"big": 2**63}]),
            ComposableNode(package="p", plugin="P"),
        ]),
    """)
    (file.parent / "some.yaml").write_text(
        "arm: {a: {ros__parameters: {special: [1], of: {it: own}, serial: '0483'}}}\n"
        "/**: {ros__parameters: {from_file: 3, speed_limit: 1.0, of: {it: any, all: 1}}}\n"
        "/other: {ros__parameters: {no: 1}}\n"
    )
    system = launched_system(file, **LONG_STOP)
    system.wait_for_log("launch", "Loaded node '/arm/a' in container '/box'")
    system.wait_for_log("launch", "Loaded node '/of_plugin' in container '/box'")
    system.wait_for_topic("/arm/to", "std_msgs/msg/String")
    system.wait_for_topic("/state_of_all", "std_msgs/msg/String")
    output, log = system.logs("box-*"), "\n".join(system.logs("launch"))
    texts = [line.partition("PARAMETERS ")[2] for line in output]
    parameters = [literal_eval(text) for text in texts if text]
    assert parameters == [
        {"of_all": 7, "from_file": 3, "special": [1], "speed_limit": 2.0, "deep.er": 3}
        | {"of.it": "own", "of.all": 1, "serial": "0483"}
        | {"b": True, "i": -1, "f": 0.5, "s": "\u00fc", "y": [b"a", b"b"]}
        | {"bs": [True, False], "is": [1, 2], "fs": [1.5], "ss": ["x", "y"]},
        {"of_all": 7},
    ]
    assert any("EXTRA {'use_intra_process_comms': True}" in line for line in output)
    assert "Failed to load node 'u' of type 'Unknown' in container '/box': no plug-in" in log
    assert "parameter 'big' cannot be sent: int too big to convert" in log
    assert "'v'" not in log


@pytest.mark.thorough
def test_a_lifecycle_node_in_a_container_is_activated_by_itself(launched_system: Launch, write):
    file = write("""
        RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=pump, goal_state="active",
            entities=[LogInfo(msg="the pump is active"), OpaqueFunction(function=has_a_time)])),
        box("box", "works", composable_node_descriptions=[
            pump,
            ComposableLifecycleNode(package="p", plugin="Unknown", name="no", autostart=True)]),
    """)
    system = launched_system(file, **LONG_STOP)
    system.wait_for_log("launch", "Autostart enabled for requested lifecycle node /site/pump")
    system.wait_for_log("launch", "Failed to load node 'no'")
    system.wait_for_log("launch", "the pump is active")
    system.wait_for_log("launch", "time True True")
    state = system.call("/site/pump/get_state")["current_state"]["label"]
    log = "\n".join(system.logs("launch"))
    assert state == "active"
    assert "Failed to make transition" not in log
    assert system.system.stop(150.0).left_processes == ()
