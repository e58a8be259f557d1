"""`launch.condition`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Condition": "launcher.language.condition",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
