"""`launch.actions.opaque_function`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import OpaqueFunction
from launcher.language.compat.names import refuse_unknown

__all__ = ["OpaqueFunction"]

__getattr__ = refuse_unknown("launch.actions.opaque_function", __all__)
