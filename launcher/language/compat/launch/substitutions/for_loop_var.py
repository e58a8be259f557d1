"""`launch.substitutions.for_loop_var`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.names import ForEachVar, ForLoopIndex

__all__ = ["ForEachVar", "ForLoopIndex"]

__getattr__ = refuse_unknown("launch.substitutions.for_loop_var", __all__)
