"""`launch.substitutions.command`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.command import Command

__all__ = ["Command"]

__getattr__ = refuse_unknown("launch.substitutions.command", __all__)
