"""`launch_ros.substitutions.find_package`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.packages import FindPackage, FindPackagePrefix, FindPackageShare

__all__ = ["FindPackage", "FindPackagePrefix", "FindPackageShare"]

__getattr__ = refuse_unknown("launch_ros.substitutions.find_package", __all__)
