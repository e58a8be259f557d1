"""`launch.substitutions.launch_log_dir`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import LaunchLogDir

__all__ = ["LaunchLogDir"]

__getattr__ = refuse_unknown("launch.substitutions.launch_log_dir", __all__)
