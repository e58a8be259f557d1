"""`launch.substitutions.find_executable`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import FindExecutable

__all__ = ["FindExecutable"]

__getattr__ = refuse_unknown("launch.substitutions.find_executable", __all__)
