"""`launch.actions.for_loop`: our vocabulary under ROS 2's name."""

from launcher.language.actions.loops import ForEach, ForLoop
from launcher.language.compat.names import refuse_unknown

__all__ = ["ForEach", "ForLoop"]

__getattr__ = refuse_unknown("launch.actions.for_loop", __all__)
