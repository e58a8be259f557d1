"""`launch_ros.default_launch_description`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.adapters import get_default_launch_description

__all__ = ["get_default_launch_description"]

__getattr__ = refuse_unknown("launch_ros.default_launch_description", __all__)
