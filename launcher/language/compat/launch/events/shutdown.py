"""`launch.events.shutdown`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import Shutdown

__all__ = ["Shutdown"]

__getattr__ = refuse_unknown("launch.events.shutdown", __all__)
