"""`launch.frontend.parser`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "InvalidFrontendLaunchFileError": "launcher.language.sources:InvalidLaunchFileError",
    "Parser": "launcher.frontends.parser",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
