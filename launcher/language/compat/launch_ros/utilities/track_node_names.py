"""`launch_ros.utilities.track_node_names`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.tracking import add_node_name, get_node_name_count

__all__ = ["add_node_name", "get_node_name_count"]

__getattr__ = refuse_unknown("launch_ros.utilities.track_node_names", __all__)
