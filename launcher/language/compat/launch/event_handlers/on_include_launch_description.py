"""`launch.event_handlers.on_include_launch_description`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnIncludeLaunchDescription

__all__ = ["OnIncludeLaunchDescription"]

__getattr__ = refuse_unknown("launch.event_handlers.on_include_launch_description", __all__)
