"""`launch.utilities.perform_substitutions_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import perform_substitutions

__all__ = ["perform_substitutions"]

__getattr__ = refuse_unknown("launch.utilities.perform_substitutions_impl", __all__)
