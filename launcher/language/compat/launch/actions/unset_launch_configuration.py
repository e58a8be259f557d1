"""`launch.actions.unset_launch_configuration`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import UnsetLaunchConfiguration
from launcher.language.compat.names import refuse_unknown

__all__ = ["UnsetLaunchConfiguration"]

__getattr__ = refuse_unknown("launch.actions.unset_launch_configuration", __all__)
