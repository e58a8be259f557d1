"""`launch.events.process.process_matchers`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import matches_executable, matches_name, matches_pid

__all__ = ["matches_executable", "matches_name", "matches_pid"]

__getattr__ = refuse_unknown("launch.events.process.process_matchers", __all__)
