"""`launch.conditions.launch_configuration_equals`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import LaunchConfigurationEquals

__all__ = ["LaunchConfigurationEquals"]

__getattr__ = refuse_unknown("launch.conditions.launch_configuration_equals", __all__)
