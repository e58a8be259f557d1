"""`launch.events.process.process_exited`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessExited

__all__ = ["ProcessExited"]

__getattr__ = refuse_unknown("launch.events.process.process_exited", __all__)
