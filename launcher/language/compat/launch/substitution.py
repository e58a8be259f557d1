"""`launch.substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitution import Substitution

__all__ = ["Substitution"]

__getattr__ = refuse_unknown("launch.substitution", __all__)
