"""`launch_xml`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Parser = borrow("launcher.frontends.xml", "XmlParser")
Entity = borrow("launcher.frontends.entity_xml", "XmlEntity")

__all__ = ["Entity", "Parser"]

__getattr__ = refuse_unknown("launch_xml", __all__)
