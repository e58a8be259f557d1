"""`launch.event_handlers.on_execution_complete`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnExecutionComplete

__all__ = ["OnExecutionComplete"]

__getattr__ = refuse_unknown("launch.event_handlers.on_execution_complete", __all__)
