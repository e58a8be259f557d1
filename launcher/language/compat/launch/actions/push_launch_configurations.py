"""`launch.actions.push_launch_configurations`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import PushLaunchConfigurations
from launcher.language.compat.names import refuse_unknown

__all__ = ["PushLaunchConfigurations"]

__getattr__ = refuse_unknown("launch.actions.push_launch_configurations", __all__)
