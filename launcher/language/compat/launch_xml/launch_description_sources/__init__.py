"""`launch_xml.launch_description_sources`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import XMLLaunchDescriptionSource

__all__ = ["XMLLaunchDescriptionSource"]

__getattr__ = refuse_unknown("launch_xml.launch_description_sources", __all__)
