"""Lifecycle nodes under the launcher: requests are really sent, transitions really seen."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from launcher.smoke.pytest_plugin import Launch
from tests.support.waiting import wait_until
from tests.system.conftest import LONG_STOP

NODE = """
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

class Pump(LifecycleNode):
    def on_configure(self, state):
        self.get_logger().info("configuring")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self.get_logger().info("activating")
        return super().on_activate(state)

try:
    rclpy.init()
    rclpy.spin(Pump("pump"))
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""

# Makes transitions as a lifecycle node does, but publishes none of them: our subscription would
# not have been discovered. `{answers}`: whether our client has been.
SILENT_NODE = """
import threading
import rclpy
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor

GOALS = {1: ("configuring", "inactive"), 3: ("activating", "active")}
rclpy.init()
node = rclpy.create_node("pump")
state, over = "unconfigured", threading.Event()

def change(request, response):
    global state
    between, state = GOALS[request.transition.id]
    node.get_logger().info(between)
    response.success = True
    if not {answers}:
        over.wait()
    return response

def tell(request, response):
    response.current_state.label = state
    return response

group = ReentrantCallbackGroup()
node.create_service(ChangeState, "pump/change_state", change, callback_group=group)
node.create_service(GetState, "pump/get_state", tell, callback_group=group)
try:
    rclpy.spin(node, MultiThreadedExecutor(4))
except (KeyboardInterrupt, ExternalShutdownException):
    over.set()
"""
NODES = {
    "all is heard": NODE,
    "events are lost": SILENT_NODE.replace("{answers}", "True"),
    "events and answers are lost": SILENT_NODE.replace("{answers}", "False"),
}

LAUNCH = """
from launch import LaunchDescription
from launch.actions import EmitEvent, LogInfo, RegisterEventHandler
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch.events import matches_action
from lifecycle_msgs.msg import Transition

def generate_launch_description():
    pump = LifecycleNode(
        executable="{python}", arguments=["{node}"], name="pump", namespace="", output="screen"
    )
    def change(transition):
        return EmitEvent(event=ChangeState(
            lifecycle_node_matcher=matches_action(pump), transition_id=transition))
    return LaunchDescription([
        pump,
        RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=pump, start_state="configuring", goal_state="inactive",
            entities=[LogInfo(msg="pump is configured"), change(Transition.TRANSITION_ACTIVATE)])),
        RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=pump, goal_state="active",
            entities=[LogInfo(msg="pump is active")])),
        change(Transition.TRANSITION_CONFIGURE),
    ])
"""


@pytest.mark.thorough
@pytest.mark.parametrize("what", NODES)
def test_a_lifecycle_node_is_configured_and_activated_by_events(
    launched_system: Launch, tmp_path: Path, what: str
):
    node = tmp_path / "pump.py"
    node.write_text(NODES[what])
    file = tmp_path / "pump.launch.py"
    file.write_text(LAUNCH.replace("{python}", sys.executable).replace("{node}", str(node)))

    system = launched_system(file, **LONG_STOP)
    system.wait_for_node("/pump")
    for process, text in (
        ("pump", "configuring"),
        ("launch", "pump is configured"),
        ("pump", "activating"),
        ("launch", "pump is active"),
    ):
        system.wait_for_log("*" if process == "pump" else process, text)
    ending = system.system.stop(150.0)
    assert sum("pump is active" in line for line in system.logs("launch")) == 1
    assert (ending.returncode, ending.left_processes) == (0, ())


LOAD = """
from launch import LaunchDescription
from launch_ros.actions import LoadComposableNodes
from launch_ros.descriptions import ComposableNode

def generate_launch_description():
    return LaunchDescription([LoadComposableNodes(
        target_container="/tank",
        composable_node_descriptions=[ComposableNode(package="p", plugin="P", name="n")])])
"""


def test_a_load_request_without_its_interface_package_fails_with_that_reason(
    launched_system: Launch, tmp_path: Path
):
    file = tmp_path / "load.launch.py"
    file.write_text(LOAD)
    system = launched_system(file, probe=False)
    system.wait_for_log("launch", "build it in a workspace: git clone .*/rcl_interfaces .* build")
    system.wait_for_log("launch", "composition_interfaces is not installed")
    system.wait_for_end()
    assert system.shutdown().left_processes == ()


AUTOSTART = """
<launch>
  <arg name="wanted"/>
  <lifecycle_node exec="{python}" args="{node} healthy" name="pump" namespace="site"
    autostart="$(var wanted)" output="screen"/>
  <lifecycle_node exec="{python}" args="{node} stuck" name="stuck" namespace=""
    autostart="true" output="screen"/>
  <lifecycle_node exec="{python}" args="{node} healthy" name="idle" namespace="" output="screen"/>
</launch>
"""
STUCK_NODE = NODE.replace("import rclpy\n", "import sys\nimport rclpy\n", 1).replace(
    'self.get_logger().info("configuring")',
    'if sys.argv[1] == "stuck":\n            return TransitionCallbackReturn.FAILURE',
)


def test_nodes_are_activated_by_themselves_and_a_failure_is_no_end(
    launched_system: Launch, tmp_path: Path
):
    node = tmp_path / "pump.py"
    node.write_text(STUCK_NODE)
    file = tmp_path / "pumps.launch.xml"
    file.write_text(AUTOSTART.replace("{python}", sys.executable).replace("{node}", str(node)))

    system = launched_system(file, wanted="true", **LONG_STOP)
    system.wait_for_log("*", r"\[site\.pump\]: activating")
    system.wait_for_log(
        "launch", "Failed to make transition 'TRANSITION_CONFIGURE' for LifecycleNode '/stuck'"
    )
    system.wait_for_node("/idle")

    def state(node: str) -> str:
        label: str = system.call(f"{node}/get_state")["current_state"]["label"]
        return label

    wait_until(lambda: state("/site/pump") == "active", "the pump is active")
    assert (state("/stuck"), state("/idle")) == ("unconfigured", "unconfigured")
    ending = system.system.stop(150.0)
    assert (ending.returncode, ending.left_processes) == (0, ())
