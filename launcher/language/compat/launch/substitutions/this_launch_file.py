"""`launch.substitutions.this_launch_file`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import ThisLaunchFile

__all__ = ["ThisLaunchFile"]

__getattr__ = refuse_unknown("launch.substitutions.this_launch_file", __all__)
