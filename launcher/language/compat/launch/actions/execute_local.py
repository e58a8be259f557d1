"""`launch.actions.execute_local`: our vocabulary under ROS 2's name."""

from launcher.language.actions.process import ExecuteLocal
from launcher.language.compat.names import refuse_unknown

__all__ = ["ExecuteLocal"]

__getattr__ = refuse_unknown("launch.actions.execute_local", __all__)
