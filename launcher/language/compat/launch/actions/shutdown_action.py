"""`launch.actions.shutdown_action`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import Shutdown
from launcher.language.compat.names import refuse_unknown

__all__ = ["Shutdown"]

__getattr__ = refuse_unknown("launch.actions.shutdown_action", __all__)
