"""`launch.actions.timer_action`: our vocabulary under ROS 2's name."""

from launcher.language.actions.timer import TimerAction
from launcher.language.compat.names import refuse_unknown

__all__ = ["TimerAction"]

__getattr__ = refuse_unknown("launch.actions.timer_action", __all__)
