"""`launch_ros.actions.set_ros_log_dir`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import SetROSLogDir

__all__ = ["SetROSLogDir"]

__getattr__ = refuse_unknown("launch_ros.actions.set_ros_log_dir", __all__)
