"""`launch.launch_description_sources.any_launch_description_source`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import AnyLaunchDescriptionSource

__all__ = ["AnyLaunchDescriptionSource"]

__getattr__ = refuse_unknown(
    "launch.launch_description_sources.any_launch_description_source", __all__
)
