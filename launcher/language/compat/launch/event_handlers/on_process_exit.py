"""`launch.event_handlers.on_process_exit`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnProcessExit

__all__ = ["OnProcessExit"]

__getattr__ = refuse_unknown("launch.event_handlers.on_process_exit", __all__)
