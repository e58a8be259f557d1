"""`launch.event_handlers.on_shutdown`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnShutdown": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
