"""`launch.frontend.parser`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown
from launcher.language.sources import InvalidLaunchFileError as InvalidFrontendLaunchFileError

Parser = borrow("launcher.frontends.parser", "Parser")

__all__ = ["InvalidFrontendLaunchFileError", "Parser"]

__getattr__ = refuse_unknown("launch.frontend.parser", __all__)
