"""`launch.events.include_launch_description`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import IncludeLaunchDescription

__all__ = ["IncludeLaunchDescription"]

__getattr__ = refuse_unknown("launch.events.include_launch_description", __all__)
