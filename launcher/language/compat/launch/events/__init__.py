"""`launch.events`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import (
    ExecutionComplete,
    IncludeLaunchDescription,
    Shutdown,
    TimerEvent,
    matches_action,
)

__all__ = [
    "ExecutionComplete",
    "IncludeLaunchDescription",
    "Shutdown",
    "TimerEvent",
    "matches_action",
]

__getattr__ = refuse_unknown("launch.events", __all__)
