"""`launch.invalid_launch_file_error`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import InvalidLaunchFileError

__all__ = ["InvalidLaunchFileError"]

__getattr__ = refuse_unknown("launch.invalid_launch_file_error", __all__)
