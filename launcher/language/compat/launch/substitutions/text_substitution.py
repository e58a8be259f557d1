"""`launch.substitutions.text_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.text import TextSubstitution

__all__ = ["TextSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions.text_substitution", __all__)
