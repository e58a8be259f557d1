"""`launch.event_handlers.on_process_start`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnProcessStart

__all__ = ["OnProcessStart"]

__getattr__ = refuse_unknown("launch.event_handlers.on_process_start", __all__)
