"""`launch_ros.actions.node`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.node import Node, NodeActionExtension

__all__ = ["Node", "NodeActionExtension"]

__getattr__ = refuse_unknown("launch_ros.actions.node", __all__)
