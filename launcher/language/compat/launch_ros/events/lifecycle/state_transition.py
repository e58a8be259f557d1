"""`launch_ros.events.lifecycle.state_transition`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import StateTransition

__all__ = ["StateTransition"]

__getattr__ = refuse_unknown("launch_ros.events.lifecycle.state_transition", __all__)
