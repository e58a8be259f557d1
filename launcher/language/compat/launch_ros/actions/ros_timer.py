"""`launch_ros.actions.ros_timer`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.timer import RosTimer
from launcher.language.ros.timer import RosTimer as ROSTimer

__all__ = ["ROSTimer", "RosTimer"]

__getattr__ = refuse_unknown("launch_ros.actions.ros_timer", __all__)
