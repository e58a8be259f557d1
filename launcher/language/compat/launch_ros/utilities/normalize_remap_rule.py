"""`launch_ros.utilities.normalize_remap_rule`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.remappings import normalize_remap_rule, normalize_remap_rules

__all__ = ["normalize_remap_rule", "normalize_remap_rules"]

__getattr__ = refuse_unknown("launch_ros.utilities.normalize_remap_rule", __all__)
