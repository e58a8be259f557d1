"""`launch.events.shutdown`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Shutdown": "launcher.language.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
