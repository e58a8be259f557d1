"""`launch_xml.entity`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

Entity = borrow("launcher.frontends.entity_xml", "XmlEntity")

__all__ = ["Entity"]

__getattr__ = refuse_unknown("launch_xml.entity", __all__)
