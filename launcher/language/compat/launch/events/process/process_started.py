"""`launch.events.process.process_started`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessStarted

__all__ = ["ProcessStarted"]

__getattr__ = refuse_unknown("launch.events.process.process_started", __all__)
