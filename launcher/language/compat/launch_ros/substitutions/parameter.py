"""`launch_ros.substitutions.parameter`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import Parameter

__all__ = ["Parameter"]

__getattr__ = refuse_unknown("launch_ros.substitutions.parameter", __all__)
