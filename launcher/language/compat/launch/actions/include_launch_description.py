"""`launch.actions.include_launch_description`: our vocabulary under ROS 2's name."""

from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.compat.names import refuse_unknown

__all__ = ["IncludeLaunchDescription"]

__getattr__ = refuse_unknown("launch.actions.include_launch_description", __all__)
