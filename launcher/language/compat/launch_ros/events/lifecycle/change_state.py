"""`launch_ros.events.lifecycle.change_state`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import ChangeState

__all__ = ["ChangeState"]

__getattr__ = refuse_unknown("launch_ros.events.lifecycle.change_state", __all__)
