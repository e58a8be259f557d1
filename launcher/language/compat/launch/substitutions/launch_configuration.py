"""`launch.substitutions.launch_configuration`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.configuration import LaunchConfiguration

__all__ = ["LaunchConfiguration"]

__getattr__ = refuse_unknown("launch.substitutions.launch_configuration", __all__)
