"""`launch_ros.actions.set_parameters_from_file`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import SetParametersFromFile

__all__ = ["SetParametersFromFile"]

__getattr__ = refuse_unknown("launch_ros.actions.set_parameters_from_file", __all__)
