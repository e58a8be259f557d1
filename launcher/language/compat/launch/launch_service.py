"""`launch.launch_service`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.service import LaunchService

__all__ = ["LaunchService"]

__getattr__ = refuse_unknown("launch.launch_service", __all__)
