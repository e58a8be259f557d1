"""`launch_testing.actions`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.testing import ReadyToTest

__all__ = ["ReadyToTest"]

__getattr__ = refuse_unknown("launch_testing.actions", __all__)
