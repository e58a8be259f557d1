"""`launch.substitutions.this_launch_file_dir`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import ThisLaunchFileDir

__all__ = ["ThisLaunchFileDir"]

__getattr__ = refuse_unknown("launch.substitutions.this_launch_file_dir", __all__)
