"""`launch_testing.markers`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.testing import keep_alive, retry_on_failure

__all__ = ["keep_alive", "retry_on_failure"]

__getattr__ = refuse_unknown("launch_testing.markers", __all__)
