"""`launch.utilities.normalize_to_list_of_substitutions_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import normalize_to_list_of_substitutions

__all__ = ["normalize_to_list_of_substitutions"]

__getattr__ = refuse_unknown("launch.utilities.normalize_to_list_of_substitutions_impl", __all__)
