"""`launch.actions.opaque_coroutine`: our vocabulary under ROS 2's name."""

from launcher.language.actions.coroutine import OpaqueCoroutine
from launcher.language.compat.names import refuse_unknown

__all__ = ["OpaqueCoroutine"]

__getattr__ = refuse_unknown("launch.actions.opaque_coroutine", __all__)
