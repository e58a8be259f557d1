"""`launch.actions.set_launch_configuration`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.compat.names import refuse_unknown

__all__ = ["SetLaunchConfiguration"]

__getattr__ = refuse_unknown("launch.actions.set_launch_configuration", __all__)
