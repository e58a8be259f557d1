"""`launch.utilities.class_tools_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import is_a, is_a_subclass, isclassinstance

__all__ = ["is_a", "is_a_subclass", "isclassinstance"]

__getattr__ = refuse_unknown("launch.utilities.class_tools_impl", __all__)
