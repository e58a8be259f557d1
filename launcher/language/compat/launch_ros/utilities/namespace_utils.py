"""`launch_ros.utilities.namespace_utils`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.names import (
    is_namespace_absolute,
    is_root_namespace,
    make_namespace_absolute,
    prefix_namespace,
)

__all__ = [
    "is_namespace_absolute",
    "is_root_namespace",
    "make_namespace_absolute",
    "prefix_namespace",
]

__getattr__ = refuse_unknown("launch_ros.utilities.namespace_utils", __all__)
