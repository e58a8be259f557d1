"""`launch.frontend.parser`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "InvalidFrontendLaunchFileError": "launcher.frontends.parser",
    "Parser": "launcher.frontends.parser",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
