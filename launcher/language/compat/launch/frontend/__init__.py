"""`launch.frontend`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Entity": "launcher.frontends.entity",
    "InvalidFrontendLaunchFileError": "launcher.language.sources:InvalidLaunchFileError",
    "Parser": "launcher.frontends.parser",
    "expose_action": "launcher.language.frontend_registry",
    "expose_substitution": "launcher.language.frontend_registry",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
