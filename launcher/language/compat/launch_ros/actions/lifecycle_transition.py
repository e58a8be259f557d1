"""`launch_ros.actions.lifecycle_transition`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.lifecycle import LifecycleTransition

__all__ = ["LifecycleTransition"]

__getattr__ = refuse_unknown("launch_ros.actions.lifecycle_transition", __all__)
