"""`launch.substitutions.if_else_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.logic import IfElseSubstitution

__all__ = ["IfElseSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.if_else_substitution", __all__)
