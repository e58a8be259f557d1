"""`launch.some_substitutions_type`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import SomeSubstitutionsType, SomeSubstitutionsType_types_tuple

__all__ = ["SomeSubstitutionsType", "SomeSubstitutionsType_types_tuple"]

__getattr__ = refuse_unknown("launch.some_substitutions_type", __all__)
