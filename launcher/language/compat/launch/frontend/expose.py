"""`launch.frontend.expose`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown
from launcher.language.frontend_registry import (
    action_parse_methods,
    expose_action,
    expose_substitution,
    substitution_parse_methods,
)

instantiate_action = borrow("launcher.frontends.expose", "instantiate_action")
instantiate_substitution = borrow("launcher.frontends.expose", "instantiate_substitution")

__all__ = [
    "action_parse_methods",
    "expose_action",
    "expose_substitution",
    "instantiate_action",
    "instantiate_substitution",
    "substitution_parse_methods",
]

__getattr__ = refuse_unknown("launch.frontend.expose", __all__)
