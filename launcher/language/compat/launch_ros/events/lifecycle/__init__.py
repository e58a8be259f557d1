"""`launch_ros.events.lifecycle`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import ChangeState, StateTransition, matches_node_name

__all__ = ["ChangeState", "StateTransition", "matches_node_name"]

__getattr__ = refuse_unknown("launch_ros.events.lifecycle", __all__)
