"""`launch.actions.reset_environment`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import ResetEnvironment
from launcher.language.compat.names import refuse_unknown

__all__ = ["ResetEnvironment"]

__getattr__ = refuse_unknown("launch.actions.reset_environment", __all__)
