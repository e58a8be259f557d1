"""`launch.events.process.process_stdout`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessStdout

__all__ = ["ProcessStdout"]

__getattr__ = refuse_unknown("launch.events.process.process_stdout", __all__)
