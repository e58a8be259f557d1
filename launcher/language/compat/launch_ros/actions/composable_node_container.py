"""`launch_ros.actions.composable_node_container`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.composition import ComposableNodeContainer

__all__ = ["ComposableNodeContainer"]

__getattr__ = refuse_unknown("launch_ros.actions.composable_node_container", __all__)
