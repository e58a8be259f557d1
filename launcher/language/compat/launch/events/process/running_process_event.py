"""`launch.events.process.running_process_event`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import RunningProcessEvent

__all__ = ["RunningProcessEvent"]

__getattr__ = refuse_unknown("launch.events.process.running_process_event", __all__)
