"""`launch.actions.unregister_event_handler`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import UnregisterEventHandler
from launcher.language.compat.names import refuse_unknown

__all__ = ["UnregisterEventHandler"]

__getattr__ = refuse_unknown("launch.actions.unregister_event_handler", __all__)
