"""`launch.events.execution_complete`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import ExecutionComplete

__all__ = ["ExecutionComplete"]

__getattr__ = refuse_unknown("launch.events.execution_complete", __all__)
