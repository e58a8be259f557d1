"""`launch.event_handler`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.event_handler import BaseEventHandler, EventHandler

__all__ = ["BaseEventHandler", "EventHandler"]

__getattr__ = refuse_unknown("launch.event_handler", __all__)
