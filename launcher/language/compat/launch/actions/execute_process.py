"""`launch.actions.execute_process`: our vocabulary under ROS 2's name."""

from launcher.language.actions.process import ExecuteProcess
from launcher.language.compat.names import refuse_unknown

__all__ = ["ExecuteProcess"]

__getattr__ = refuse_unknown("launch.actions.execute_process", __all__)
