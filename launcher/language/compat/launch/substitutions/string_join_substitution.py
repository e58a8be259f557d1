"""`launch.substitutions.string_join_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.text import StringJoinSubstitution

__all__ = ["StringJoinSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.string_join_substitution", __all__)
