"""`launch.events.process.signal_process`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import SignalProcess

__all__ = ["SignalProcess"]

__getattr__ = refuse_unknown("launch.events.process.signal_process", __all__)
