"""`launch.events.process.process_started`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ProcessStarted": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
