"""`launch.launch_introspector`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.introspection import LaunchIntrospector

__all__ = ["LaunchIntrospector"]

__getattr__ = refuse_unknown("launch.launch_introspector", __all__)
