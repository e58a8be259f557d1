"""`launch_yaml.launch_description_sources.yaml_launch_description_source`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import YAMLLaunchDescriptionSource

__all__ = ["YAMLLaunchDescriptionSource"]

__getattr__ = refuse_unknown(
    "launch_yaml.launch_description_sources.yaml_launch_description_source", __all__
)
