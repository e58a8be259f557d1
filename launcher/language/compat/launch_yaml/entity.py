"""`launch_yaml.entity`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Entity = borrow("launcher.frontends.entity_yaml", "YamlEntity")

__all__ = ["Entity"]

__getattr__ = refuse_unknown("launch_yaml.entity", __all__)
