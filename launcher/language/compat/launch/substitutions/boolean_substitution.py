"""`launch.substitutions.boolean_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.logic import (
    AllSubstitution,
    AndSubstitution,
    AnySubstitution,
    NotSubstitution,
    OrSubstitution,
)

__all__ = [
    "AllSubstitution",
    "AndSubstitution",
    "AnySubstitution",
    "NotSubstitution",
    "OrSubstitution",
]

__getattr__ = refuse_unknown("launch.substitutions.boolean_substitution", __all__)
