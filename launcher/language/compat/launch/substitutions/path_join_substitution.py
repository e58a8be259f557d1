"""`launch.substitutions.path_join_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import PathJoinSubstitution

__all__ = ["PathJoinSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.path_join_substitution", __all__)
