"""A dispatcher, two robots and a monitor."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def fleet_node(executable, name=None, **options):
    """One node of the package, with its output on the screen."""
    return Node(
        package="fleet_nodes",
        executable=executable,
        name=name or executable,
        output="screen",
        emulate_tty=True,
        **options,
    )


def generate_launch_description():
    duration_s = LaunchConfiguration("task_duration_s")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "period_s", default_value="1.0", description="Seconds between two assignments."
            ),
            DeclareLaunchArgument(
                "task_duration_s", default_value="0.5", description="Seconds that a task takes."
            ),
            DeclareLaunchArgument(
                "start_robot_2",
                default_value="true",
                choices=["true", "false"],
                description="Start the second robot.",
            ),
            fleet_node("monitor"),
            fleet_node("robot", "robot_1", parameters=[{"task_duration_s": duration_s}]),
            fleet_node(
                "robot",
                "robot_2",
                parameters=[{"task_duration_s": duration_s}],
                condition=IfCondition(LaunchConfiguration("start_robot_2")),
            ),
            fleet_node("dispatcher", parameters=[{"period_s": LaunchConfiguration("period_s")}]),
        ]
    )
