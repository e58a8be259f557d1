"""`launch_xml.launch_description_sources.xml_launch_description_source`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import XMLLaunchDescriptionSource

__all__ = ["XMLLaunchDescriptionSource"]

__getattr__ = refuse_unknown(
    "launch_xml.launch_description_sources.xml_launch_description_source", __all__
)
