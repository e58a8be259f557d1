"""`launch_ros.actions.set_parameter`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import SetParameter

__all__ = ["SetParameter"]

__getattr__ = refuse_unknown("launch_ros.actions.set_parameter", __all__)
