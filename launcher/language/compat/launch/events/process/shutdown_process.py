"""`launch.events.process.shutdown_process`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ShutdownProcess

__all__ = ["ShutdownProcess"]

__getattr__ = refuse_unknown("launch.events.process.shutdown_process", __all__)
