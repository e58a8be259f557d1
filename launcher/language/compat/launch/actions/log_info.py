"""`launch.actions.log_info`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import LogInfo
from launcher.language.compat.names import refuse_unknown

__all__ = ["LogInfo"]

__getattr__ = refuse_unknown("launch.actions.log_info", __all__)
