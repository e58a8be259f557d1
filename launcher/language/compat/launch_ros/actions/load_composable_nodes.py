"""`launch_ros.actions.load_composable_nodes`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.composition import LoadComposableNodes, get_composable_node_load_request

__all__ = ["LoadComposableNodes", "get_composable_node_load_request"]

__getattr__ = refuse_unknown("launch_ros.actions.load_composable_nodes", __all__)
