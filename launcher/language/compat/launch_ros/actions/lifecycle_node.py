"""`launch_ros.actions.lifecycle_node`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import LifecycleNode

__all__ = ["LifecycleNode"]

__getattr__ = refuse_unknown("launch_ros.actions.lifecycle_node", __all__)
