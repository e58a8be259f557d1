"""`launch_ros.remap_rule_type`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.some_types import RemapRule, RemapRules, SomeRemapRule, SomeRemapRules

__all__ = ["RemapRule", "RemapRules", "SomeRemapRule", "SomeRemapRules"]

__getattr__ = refuse_unknown("launch_ros.remap_rule_type", __all__)
