"""`launch.actions.log`: our vocabulary under ROS 2's name."""

from launcher.language.actions.events import LogInfo
from launcher.language.actions.logs import Log, LogDebug, LogError, LogWarning
from launcher.language.compat.names import refuse_unknown

__all__ = ["Log", "LogDebug", "LogError", "LogInfo", "LogWarning"]

__getattr__ = refuse_unknown("launch.actions.log", __all__)
