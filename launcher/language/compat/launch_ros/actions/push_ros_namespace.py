"""`launch_ros.actions.push_ros_namespace`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.scope import PushROSNamespace
from launcher.language.ros.scope import PushROSNamespace as PushRosNamespace

__all__ = ["PushROSNamespace", "PushRosNamespace"]

__getattr__ = refuse_unknown("launch_ros.actions.push_ros_namespace", __all__)
