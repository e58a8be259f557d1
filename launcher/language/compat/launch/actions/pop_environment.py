"""`launch.actions.pop_environment`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import PopEnvironment
from launcher.language.compat.names import refuse_unknown

__all__ = ["PopEnvironment"]

__getattr__ = refuse_unknown("launch.actions.pop_environment", __all__)
