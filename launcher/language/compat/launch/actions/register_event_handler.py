"""`launch.actions.register_event_handler`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import RegisterEventHandler
from launcher.language.compat.names import refuse_unknown

__all__ = ["RegisterEventHandler"]

__getattr__ = refuse_unknown("launch.actions.register_event_handler", __all__)
