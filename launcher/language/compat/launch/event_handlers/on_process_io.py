"""`launch.event_handlers.on_process_io`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnProcessIO": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
