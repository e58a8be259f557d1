"""`launch_ros.descriptions.node_trait`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.node_descriptions import NodeTrait

__all__ = ["NodeTrait"]

__getattr__ = refuse_unknown("launch_ros.descriptions.node_trait", __all__)
