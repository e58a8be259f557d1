"""`launch.event_handlers.on_action_event_base`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnActionEventBase

__all__ = ["OnActionEventBase"]

__getattr__ = refuse_unknown("launch.event_handlers.on_action_event_base", __all__)
