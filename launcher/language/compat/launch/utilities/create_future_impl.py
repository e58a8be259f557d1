"""`launch.utilities.create_future_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import create_future

__all__ = ["create_future"]

__getattr__ = refuse_unknown("launch.utilities.create_future_impl", __all__)
