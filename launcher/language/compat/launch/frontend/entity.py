"""`launch.frontend.entity`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Entity = borrow("launcher.frontends.entity", "Entity")

__all__ = ["Entity"]

__getattr__ = refuse_unknown("launch.frontend.entity", __all__)
