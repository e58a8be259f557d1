"""`launch_ros.actions.set_remap`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import SetRemap

__all__ = ["SetRemap"]

__getattr__ = refuse_unknown("launch_ros.actions.set_remap", __all__)
