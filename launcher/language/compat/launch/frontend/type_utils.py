"""`launch.frontend.type_utils`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

get_data_type_from_identifier = borrow("launcher.frontends.types", "get_data_type_from_identifier")

__all__ = ["get_data_type_from_identifier"]

__getattr__ = refuse_unknown("launch.frontend.type_utils", __all__)
