"""`launch.event_handlers.on_process_io`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnProcessIO

__all__ = ["OnProcessIO"]

__getattr__ = refuse_unknown("launch.event_handlers.on_process_io", __all__)
