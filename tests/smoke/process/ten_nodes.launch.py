"""Ten nodes, one of which is started late, and a process that exits."""

import sys

from launch import LaunchDescription
from launch.actions import ExecuteProcess, TimerAction

ROLES = ("steady", "fast", "slow", "keeper", "switch", "engine", "mixed", "anonymous", "moody")


def role(name):
    return ExecuteProcess(
        cmd=[sys.executable, "-m", "tests.smoke.process.ten_nodes", name],
        name=name,
        output="screen",
    )


def generate_launch_description():
    """Describe the system."""
    return LaunchDescription(
        [
            ExecuteProcess(cmd=["echo", "prepared"], name="prepare", output="screen"),
            *(role(name) for name in ROLES),
            TimerAction(period=4.0, actions=[role("late")]),
        ]
    )
