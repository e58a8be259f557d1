"""`launch.events.process.signal_process`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SignalProcess": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
