"""`launch_ros.utilities.normalize_parameters`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.parameter_values import normalize_parameter_dict, normalize_parameters

__all__ = ["normalize_parameter_dict", "normalize_parameters"]

__getattr__ = refuse_unknown("launch_ros.utilities.normalize_parameters", __all__)
