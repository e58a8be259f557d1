"""`launch.actions.pop_launch_configurations`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import PopLaunchConfigurations
from launcher.language.compat.names import refuse_unknown

__all__ = ["PopLaunchConfigurations"]

__getattr__ = refuse_unknown("launch.actions.pop_launch_configurations", __all__)
