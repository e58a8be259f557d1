"""`launch_ros.utilities.evaluate_parameters`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.parameter_values import evaluate_parameter_dict, evaluate_parameters

__all__ = ["evaluate_parameter_dict", "evaluate_parameters"]

__getattr__ = refuse_unknown("launch_ros.utilities.evaluate_parameters", __all__)
