"""`launch_yaml`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Parser = borrow("launcher.frontends.yaml", "YamlParser")
Entity = borrow("launcher.frontends.entity_yaml", "YamlEntity")

__all__ = ["Entity", "Parser"]

__getattr__ = refuse_unknown("launch_yaml", __all__)
