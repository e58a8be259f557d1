"""`launch_yaml.parser`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Parser = borrow("launcher.frontends.yaml", "YamlParser")

__all__ = ["Parser"]

__getattr__ = refuse_unknown("launch_yaml.parser", __all__)
