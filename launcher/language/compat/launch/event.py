"""`launch.event`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Event": "launcher.language.event",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
