"""`launch.event_handlers.event_named`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import event_named

__all__ = ["event_named"]

__getattr__ = refuse_unknown("launch.event_handlers.event_named", __all__)
