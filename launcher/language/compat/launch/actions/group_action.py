"""`launch.actions.group_action`: our vocabulary under ROS 2's name."""

from launcher.language.actions.group import GroupAction
from launcher.language.compat.names import refuse_unknown

__all__ = ["GroupAction"]

__getattr__ = refuse_unknown("launch.actions.group_action", __all__)
