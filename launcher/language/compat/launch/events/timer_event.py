"""`launch.events.timer_event`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import TimerEvent

__all__ = ["TimerEvent"]

__getattr__ = refuse_unknown("launch.events.timer_event", __all__)
