"""`launch.logging.handlers`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.log import SessionHandler as StreamHandler

__all__ = ["StreamHandler"]

__getattr__ = refuse_unknown("launch.logging.handlers", __all__)
