"""`launch_ros.descriptions.ros_executable`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.executable import RosExecutable

__all__ = ["RosExecutable"]

__getattr__ = refuse_unknown("launch_ros.descriptions.ros_executable", __all__)
