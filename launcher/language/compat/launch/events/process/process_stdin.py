"""`launch.events.process.process_stdin`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessStdin

__all__ = ["ProcessStdin"]

__getattr__ = refuse_unknown("launch.events.process.process_stdin", __all__)
