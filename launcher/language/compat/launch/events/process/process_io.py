"""`launch.events.process.process_io`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessIO

__all__ = ["ProcessIO"]

__getattr__ = refuse_unknown("launch.events.process.process_io", __all__)
