"""`launch.conditions.if_condition`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import IfCondition

__all__ = ["IfCondition"]

__getattr__ = refuse_unknown("launch.conditions.if_condition", __all__)
