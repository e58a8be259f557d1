"""`launch.launch_description`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.description import LaunchDescription

__all__ = ["LaunchDescription"]

__getattr__ = refuse_unknown("launch.launch_description", __all__)
