"""`launch_ros.utilities.to_parameters_list`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.component_parameters import to_parameters_list

__all__ = ["to_parameters_list"]

__getattr__ = refuse_unknown("launch_ros.utilities.to_parameters_list", __all__)
