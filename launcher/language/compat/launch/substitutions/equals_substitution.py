"""`launch.substitutions.equals_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.logic import EqualsSubstitution

__all__ = ["EqualsSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.equals_substitution", __all__)
