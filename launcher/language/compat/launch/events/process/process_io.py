"""`launch.events.process.process_io`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ProcessIO": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
