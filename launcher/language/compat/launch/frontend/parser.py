"""Re-exports of `launch.frontend.parser`."""

from launcher.frontends.parser import InvalidFrontendLaunchFileError, Parser
from launcher.language.compat.names import refuse_unknown

__all__ = ["InvalidFrontendLaunchFileError", "Parser"]

__getattr__ = refuse_unknown("launch.frontend.parser", __all__)
