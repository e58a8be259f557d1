"""`launch_ros.ros_adapters`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.adapters import ROSAdapter, get_ros_adapter, get_ros_node

__all__ = ["ROSAdapter", "get_ros_adapter", "get_ros_node"]

__getattr__ = refuse_unknown("launch_ros.ros_adapters", __all__)
