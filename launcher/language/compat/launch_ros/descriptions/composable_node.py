"""`launch_ros.descriptions.composable_node`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.composition import ComposableNode

__all__ = ["ComposableNode"]

__getattr__ = refuse_unknown("launch_ros.descriptions.composable_node", __all__)
