"""ROS adapters: ROS 2's node inside of the launcher. There is none here."""

from __future__ import annotations

from launcher.language.description import LaunchDescription
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


@public("launch_ros.ros_adapters")
class ROSAdapter:
    """Would hold a node inside of the launcher; RuntimeError when constructed."""

    def __init__(self, *, argv: Any = None, autostart: bool = True) -> None:
        _refuse()


def get_ros_adapter(context: Any) -> NoReturn:
    """RuntimeError: this launcher keeps rclpy out of its own process."""
    _refuse()


def get_ros_node(context: Any) -> NoReturn:
    """RuntimeError: this launcher keeps rclpy out of its own process."""
    _refuse()


def _refuse() -> NoReturn:
    raise RuntimeError(
        "this launcher has no ROS node of its own; "
        "start a process that does the work, or use the actions for services and parameters"
    )


def get_default_launch_description() -> LaunchDescription:
    """An empty description: nothing has to be set up."""
    return LaunchDescription([])
