"""
A warehouse: many robots of one class, generated or from a fleet file; dispatcher and monitor.

With an installation of ROS 2: `ros2 launch group_gp1 warehouse.launch.py robots:=20`; without one:
`python -m launcher warehouse robots:=100 --discovery server`.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from group_gp1.logic import fleet
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

Number = TypeVar('Number', int, float)

DEFAULT_ROBOTS = 10
MAX_DEPTH = 1000  # of a queue
LISTED_ROBOTS = 20  # a report of more is a summary
BASE_SILENCE_S = 5.0  # as in a small fleet
SILENCE_S = 0.1  # longer for each robot: the machine is busy while many start
START_S = 1.0  # until a robot reports, for each that starts at the same time on a slow machine
BASE_GRACE_S = 7.0  # what the monitor gives a small fleet

ARGUMENTS = {
    'robots': (
        '',
        f'How many robots, 1 to {fleet.MAX_ROBOTS} ({DEFAULT_ROBOTS} without a fleet).',
    ),
    'fleet': ('', 'A fleet file in YAML, in place of `robots`.'),
    'seed': ('0', 'The task durations are drawn with it, where none is given.'),
    'task_period': ('20.0', 'Each robot gets a task once in this time, if it is idle (seconds).'),
    'output': ('screen', 'Where the lines of robots go: screen, log, both, own_log or full.'),
    'transport': ('UDPv4', 'FASTDDS_BUILTIN_TRANSPORTS of all nodes; DEFAULT has shared memory.'),
}


def text_of(context: LaunchContext, name: str) -> str:
    """Return the value of an argument."""
    return LaunchConfiguration(name).perform(context)


def number_of(context: LaunchContext, name: str, kind: Callable[[str], Number]) -> Number:
    """Return the value of an argument as a number; the error says which one is wrong."""
    text = text_of(context, name)
    try:
        return kind(text)
    except ValueError:
        raise fleet.FleetError(f'{name}:={text} is not a number') from None


def fleet_of(context: LaunchContext) -> list[fleet.FleetRobot]:
    """Return the robots that the arguments ask for."""
    path, count = text_of(context, 'fleet'), text_of(context, 'robots')
    seed = number_of(context, 'seed', int)
    if not path:
        return fleet.generate(number_of(context, 'robots', int) if count else DEFAULT_ROBOTS, seed)
    if count:
        raise fleet.FleetError('robots:= and fleet:= exclude each other: the file has the robots')
    return fleet.read(path, seed)


def rate_hz_of(context: LaunchContext, robots: int) -> float:
    """Return how many assignments a second that number of robots gets."""
    period_s = number_of(context, 'task_period', float)
    if not 0.1 <= period_s <= 3600.0:
        raise fleet.FleetError(f'task_period:={period_s:g} is not between 0.1 and 3600 seconds')
    return min(max(robots / period_s, 0.01), 1000.0)


def fleet_node(executable: str, parameters: dict[str, Any]) -> Node:
    """Make the dispatcher or the monitor; executable and node have the same name."""
    return Node(
        package='group_gp1',
        executable=executable,
        name=executable,
        output='screen',
        parameters=[parameters],
    )


def robot_node(robot: fleet.FleetRobot, queue_depth: int) -> Node:
    """Make a robot; its node has its id as its name."""
    return Node(
        package='group_gp1',
        executable='robot',
        name=robot.robot_id,
        output=LaunchConfiguration('output'),
        parameters=[{**robot.parameters(), 'task_queue_depth': queue_depth}],
    )


def nodes(context: LaunchContext) -> list[Node]:
    """Make all nodes; what depends on the size of the fleet is in the parameters."""
    robots = fleet_of(context)
    rate_hz = rate_hz_of(context, len(robots))
    silence_timeout_s = max(
        BASE_SILENCE_S + SILENCE_S * len(robots),
        2.0 * max(robot.longest_silence_s for robot in robots),
    )
    common = {
        'robot_ids': [robot.robot_id for robot in robots],
        'silence_timeout_s': silence_timeout_s,
        # one status of each robot, and those before and after a task
        'status_queue_depth': min(3 * len(robots), MAX_DEPTH),
    }
    dispatcher = {
        **common,
        'dispatch_rate_hz': rate_hz,
        'assign_when_idle': True,
        # a robot that is just being connected gets what was assigned in the last 5 s
        'task_history_depth': max(5, min(round(5.0 * rate_hz), MAX_DEPTH)),
    }
    monitor = {
        **common,
        'listed_robots': LISTED_ROBOTS,
        'start_grace_s': BASE_GRACE_S + START_S * len(robots),
    }
    # assignments to all others arrive while a robot works
    queue_depth = max(5, min(round(2.0 * rate_hz * silence_timeout_s), MAX_DEPTH))
    return [
        fleet_node('dispatcher', dispatcher),
        fleet_node('monitor', monitor),
        *(robot_node(robot, queue_depth) for robot in robots),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the warehouse."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=about)
                for name, (default, about) in ARGUMENTS.items()
            ),
            SetEnvironmentVariable('FASTDDS_BUILTIN_TRANSPORTS', LaunchConfiguration('transport')),
            OpaqueFunction(function=nodes),
        ]
    )
