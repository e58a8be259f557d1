"""`launch.utilities.ensure_argument_type_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import ensure_argument_type

__all__ = ["ensure_argument_type"]

__getattr__ = refuse_unknown("launch.utilities.ensure_argument_type_impl", __all__)
