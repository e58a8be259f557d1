"""`launch_ros.actions.set_use_sim_time`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import SetUseSimTime

__all__ = ["SetUseSimTime"]

__getattr__ = refuse_unknown("launch_ros.actions.set_use_sim_time", __all__)
