"""`launch_testing.util`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.testing import KeepAliveProc

__all__ = ["KeepAliveProc"]

__getattr__ = refuse_unknown("launch_testing.util", __all__)
