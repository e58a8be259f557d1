"""`launch.action`: our vocabulary under ROS 2's name."""

from launcher.language.action import Action
from launcher.language.compat.names import refuse_unknown

__all__ = ["Action"]

__getattr__ = refuse_unknown("launch.action", __all__)
