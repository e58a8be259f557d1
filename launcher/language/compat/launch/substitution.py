"""`launch.substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Substitution": "launcher.language.substitution",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
