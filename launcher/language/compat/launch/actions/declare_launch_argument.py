"""`launch.actions.declare_launch_argument`: our vocabulary under ROS 2's name."""

from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.compat.names import refuse_unknown

__all__ = ["DeclareLaunchArgument"]

__getattr__ = refuse_unknown("launch.actions.declare_launch_argument", __all__)
