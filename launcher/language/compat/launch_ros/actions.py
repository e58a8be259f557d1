"""Re-exports of `launch_ros.actions`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.node import Node

__all__ = ["Node"]

__getattr__ = refuse_unknown("launch_ros.actions", __all__)
