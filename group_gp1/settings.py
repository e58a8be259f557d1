"""
ROS parameters of a node with type, default, range and unit, read once.

All are read-only: a node reads them at its start, so `ros2 param set` is rejected instead of
having no effect.
"""

from __future__ import annotations

from typing import Any

from group_gp1 import qos
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter


class SettingError(Exception):
    """A parameter has an invalid value; the text is for the user."""


def number(
    node: Node, name: str, default: float, *, low: float, high: float, unit: str, about: str
) -> float:
    """Declare a floating point parameter and read it; the range includes `low` and `high`."""
    descriptor = ParameterDescriptor(
        type=Parameter.Type.DOUBLE.value,
        description=f'{about} [{unit}]',
        floating_point_range=[FloatingPointRange(from_value=low, to_value=high)],
        read_only=True,
    )
    rule = f'a number from {low:g} to {high:g} {unit}, written with a point'
    return float(_declare(node, name, default, descriptor, rule))


def whole_number(
    node: Node, name: str, default: int, *, low: int, high: int, unit: str, about: str
) -> int:
    """Declare an integer parameter and read it; the range includes `low` and `high`."""
    descriptor = ParameterDescriptor(
        type=Parameter.Type.INTEGER.value,
        description=f'{about} [{unit}]',
        integer_range=[IntegerRange(from_value=low, to_value=high)],
        read_only=True,
    )
    rule = f'a whole number from {low} to {high} ({unit})'
    return int(_declare(node, name, default, descriptor, rule))


def silence_timeout_s(node: Node) -> float:
    """Declare when a robot counts as silent and read it."""
    return number(
        node,
        'silence_timeout_s',
        5.0,
        low=0.1,
        high=3600.0,
        unit='s',
        about='Silence of a robot after which the monitor warns',
    )


def status_queue_depth(node: Node) -> int:
    """Declare the depth of a reader of `/fleet/status` and read it."""
    return whole_number(
        node,
        'status_queue_depth',
        qos.STATUS_DEPTH,
        low=1,
        high=qos.MAX_DEPTH,
        unit='messages',
        about='Statuses that wait while the node is busy: one of each robot is enough',
    )


def switch(node: Node, name: str, *, about: str) -> bool:
    """Declare a parameter that is false by default and read it."""
    descriptor = ParameterDescriptor(
        type=Parameter.Type.BOOL.value, description=about, read_only=True
    )
    return bool(_declare(node, name, False, descriptor, 'true or false'))


def names(node: Node, name: str, default: list[str], *, about: str) -> list[str]:
    """Declare a list of distinct, non-empty names and read it."""
    descriptor = ParameterDescriptor(
        type=Parameter.Type.STRING_ARRAY.value,
        description=about,
        additional_constraints='at least one name, no empty one, none twice',
        read_only=True,
    )
    rule = 'a list of distinct names such as [robot_1,robot_2]'
    given = _declare(node, name, default, descriptor, rule)
    values = [str(value) for value in given or ()]  # rclpy returns None for an empty list
    if not values or not all(values) or len(set(values)) != len(values):
        raise _error(node, name, rule, values)
    return values


def _declare(
    node: Node, name: str, default: Any, descriptor: ParameterDescriptor, rule: str
) -> Any:
    try:
        return node.declare_parameter(name, default, descriptor).value
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise _error(node, name, rule, str(error)) from None


def _error(node: Node, name: str, rule: str, found: object) -> SettingError:
    return SettingError(f"{node.get_name()}: parameter '{name}' must be {rule}. Found: {found}")
