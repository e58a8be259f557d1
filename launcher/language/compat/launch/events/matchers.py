"""`launch.events.matchers`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import matches_action

__all__ = ["matches_action"]

__getattr__ = refuse_unknown("launch.events.matchers", __all__)
