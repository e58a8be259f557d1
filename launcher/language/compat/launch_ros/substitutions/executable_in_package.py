"""`launch_ros.substitutions.executable_in_package`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.packages import ExecutableInPackage

__all__ = ["ExecutableInPackage"]

__getattr__ = refuse_unknown("launch_ros.substitutions.executable_in_package", __all__)
