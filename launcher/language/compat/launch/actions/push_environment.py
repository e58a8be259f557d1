"""`launch.actions.push_environment`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import PushEnvironment
from launcher.language.compat.names import refuse_unknown

__all__ = ["PushEnvironment"]

__getattr__ = refuse_unknown("launch.actions.push_environment", __all__)
