"""`launch_ros.descriptions.node`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.node_descriptions import Node

__all__ = ["Node"]

__getattr__ = refuse_unknown("launch_ros.descriptions.node", __all__)
