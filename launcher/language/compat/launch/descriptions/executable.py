"""`launch.descriptions.executable`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.executable import Executable

__all__ = ["Executable"]

__getattr__ = refuse_unknown("launch.descriptions.executable", __all__)
