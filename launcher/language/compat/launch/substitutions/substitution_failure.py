"""`launch.substitutions.substitution_failure`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitution import SubstitutionFailure

__all__ = ["SubstitutionFailure"]

__getattr__ = refuse_unknown("launch.substitutions.substitution_failure", __all__)
