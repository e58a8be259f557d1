"""`launch.substitutions.path_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import PathSubstitution

__all__ = ["PathSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.path_substitution", __all__)
