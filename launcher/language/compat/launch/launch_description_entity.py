"""`launch.launch_description_entity`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.entity import LaunchDescriptionEntity

__all__ = ["LaunchDescriptionEntity"]

__getattr__ = refuse_unknown("launch.launch_description_entity", __all__)
