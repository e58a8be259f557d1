"""`launch.events.process.process_stderr`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessStderr

__all__ = ["ProcessStderr"]

__getattr__ = refuse_unknown("launch.events.process.process_stderr", __all__)
