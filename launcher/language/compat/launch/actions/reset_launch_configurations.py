"""`launch.actions.reset_launch_configurations`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import ResetLaunchConfigurations
from launcher.language.compat.names import refuse_unknown

__all__ = ["ResetLaunchConfigurations"]

__getattr__ = refuse_unknown("launch.actions.reset_launch_configurations", __all__)
