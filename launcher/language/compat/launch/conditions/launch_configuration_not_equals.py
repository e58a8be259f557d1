"""`launch.conditions.launch_configuration_not_equals`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import LaunchConfigurationNotEquals

__all__ = ["LaunchConfigurationNotEquals"]

__getattr__ = refuse_unknown("launch.conditions.launch_configuration_not_equals", __all__)
