"""`launch_ros.event_handlers.on_state_transition`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import OnStateTransition

__all__ = ["OnStateTransition"]

__getattr__ = refuse_unknown("launch_ros.event_handlers.on_state_transition", __all__)
