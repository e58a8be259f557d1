"""`launch.event`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.event import Event

__all__ = ["Event"]

__getattr__ = refuse_unknown("launch.event", __all__)
