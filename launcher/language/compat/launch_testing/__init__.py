"""`launch_testing`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.testing import parametrize, post_shutdown_test

__all__ = ["parametrize", "post_shutdown_test"]

__getattr__ = refuse_unknown("launch_testing", __all__)
