"""`launch.condition`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.condition import Condition

__all__ = ["Condition"]

__getattr__ = refuse_unknown("launch.condition", __all__)
