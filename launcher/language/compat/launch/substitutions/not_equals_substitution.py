"""`launch.substitutions.not_equals_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.logic import NotEqualsSubstitution

__all__ = ["NotEqualsSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.not_equals_substitution", __all__)
