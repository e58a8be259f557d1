"""`launch.frontend`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown
from launcher.language.frontend_registry import expose_action, expose_substitution
from launcher.language.sources import InvalidLaunchFileError as InvalidFrontendLaunchFileError

Entity = borrow("launcher.frontends.entity", "Entity")
Parser = borrow("launcher.frontends.parser", "Parser")

__all__ = [
    "Entity",
    "InvalidFrontendLaunchFileError",
    "Parser",
    "expose_action",
    "expose_substitution",
]

__getattr__ = refuse_unknown("launch.frontend", __all__)
