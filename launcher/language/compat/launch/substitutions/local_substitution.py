"""`launch.substitutions.local_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.configuration import LocalSubstitution

__all__ = ["LocalSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.local_substitution", __all__)
