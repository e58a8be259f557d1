"""`launch.conditions.unless_condition`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import UnlessCondition

__all__ = ["UnlessCondition"]

__getattr__ = refuse_unknown("launch.conditions.unless_condition", __all__)
