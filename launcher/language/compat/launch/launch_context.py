"""`launch.launch_context`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.context import LaunchContext

__all__ = ["LaunchContext"]

__getattr__ = refuse_unknown("launch.launch_context", __all__)
