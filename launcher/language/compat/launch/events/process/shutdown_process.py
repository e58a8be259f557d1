"""`launch.events.process.shutdown_process`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ShutdownProcess": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
