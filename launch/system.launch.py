"""
The whole fleet: dispatcher, monitor, three robots, and two optional helpers.

With an installation of ROS 2: `ros2 launch group_gp1 system.launch.py enable_debug:=true`;
without one: `python -m launcher system enable_debug:=true`.
"""

from launch import Condition, LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, TimerAction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ROBOT_3_DELAY_S = 5.0  # late enough for a backlog on /fleet/tasks
SWITCH = ['true', 'false', 'True', 'False', 'TRUE', 'FALSE', '1', '0']  # what IfCondition accepts


def fleet_node(name: str, condition: Condition | None = None) -> Node:
    """Make one node of the fleet; executable and node have the same name."""
    return Node(
        package='group_gp1',
        executable=name,
        name=name,
        output='screen',
        emulate_tty=True,
        condition=condition,
    )


def generate_launch_description() -> LaunchDescription:
    """Describe the system."""
    arguments = [
        DeclareLaunchArgument(
            'enable_debug',
            default_value='false',
            description='Start debug_logger, which logs every task and every status (true/false).',
            choices=SWITCH,
        ),
        DeclareLaunchArgument(
            'start_robot_2',
            default_value='true',
            description='Start robot_2, the slow robot (true/false).',
            choices=SWITCH,
        ),
        DeclareLaunchArgument(
            'enable_qos_probe',
            default_value='false',
            description='Start qos_probe, a subscriber with incompatible QoS (true/false).',
            choices=SWITCH,
        ),
    ]
    robots = GroupAction(
        [
            fleet_node('robot_1'),
            fleet_node('robot_2', IfCondition(LaunchConfiguration('start_robot_2'))),
            TimerAction(period=ROBOT_3_DELAY_S, actions=[fleet_node('robot_3')]),
        ]
    )
    return LaunchDescription(
        [
            *arguments,
            fleet_node('dispatcher'),
            fleet_node('monitor'),
            robots,
            fleet_node('debug_logger', IfCondition(LaunchConfiguration('enable_debug'))),
            fleet_node('qos_probe', IfCondition(LaunchConfiguration('enable_qos_probe'))),
        ]
    )
