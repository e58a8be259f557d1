"""RosTimer: on the clock of the simulation after SetUseSimTime, otherwise on wall time."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.smoke.pytest_plugin import Launch
from tests.system.conftest import LONG_STOP

# Begins at 0, and passes 40 s each second.
CLOCK = """
import rclpy
from rclpy.executors import ExternalShutdownException
from rosgraph_msgs.msg import Clock

rclpy.init()
node = rclpy.create_node("simulation")
publisher, now = node.create_publisher(Clock, "/clock", 10), Clock()

def tick():
    now.clock.sec += 1
    publisher.publish(now)

node.create_timer(1 / 40, tick)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""

LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess, LogInfo, OpaqueFunction, TimerAction
from launch_ros.actions import RosTimer, SetUseSimTime

def timer(period, text, **options):
    return RosTimer(period=period, actions=[LogInfo(msg=text)], **options)

cancelled = timer(210.0, "cancelled timer")

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, "{clock}"], output="screen"),
        timer(200.0, "begun before"),  # moves to the clock of the simulation
        TimerAction(period=0.1, actions=[LogInfo(msg="wall time")]),
        TimerAction(period=1.0, actions=[
            SetUseSimTime(True),
            timer(220.0, "second timer"),
            cancelled,
            OpaqueFunction(function=lambda context: cancelled.cancel()),
        ]),
        timer(9000.0, "never"),
    ])
"""


@pytest.mark.thorough
def test_timers_follow_the_clock_of_the_simulation(launched_system: Launch, tmp_path: Path):
    clock, file = tmp_path / "clock.py", tmp_path / "timer.launch.py"
    clock.write_text(CLOCK)
    file.write_text(LAUNCH.replace("{clock}", str(clock)))

    system = launched_system(file, **LONG_STOP)
    for text in ("wall time", "begun before", "second timer"):
        system.wait_for_log("launch", text)
    ending = system.system.stop(150.0)
    assert (ending.returncode, ending.left_processes) == (0, ())
    assert not [line for line in system.logs("launch") if "cancelled timer" in line]
