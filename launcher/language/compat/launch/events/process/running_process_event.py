"""`launch.events.process.running_process_event`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "RunningProcessEvent": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
