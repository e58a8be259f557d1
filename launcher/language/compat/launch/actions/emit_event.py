"""`launch.actions.emit_event`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import EmitEvent
from launcher.language.compat.names import refuse_unknown

__all__ = ["EmitEvent"]

__getattr__ = refuse_unknown("launch.actions.emit_event", __all__)
