"""`launch.event_handlers.on_shutdown`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnShutdown

__all__ = ["OnShutdown"]

__getattr__ = refuse_unknown("launch.event_handlers.on_shutdown", __all__)
