"""`launch_xml.parser`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Parser = borrow("launcher.frontends.xml", "XmlParser")

__all__ = ["Parser"]

__getattr__ = refuse_unknown("launch_xml.parser", __all__)
