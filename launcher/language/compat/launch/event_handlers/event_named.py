"""`launch.event_handlers.event_named`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "event_named": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
