"""`launch_ros.events`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import matches_node_name

__all__ = ["matches_node_name"]

__getattr__ = refuse_unknown("launch_ros.events", __all__)
