"""`launch.events.timer_event`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "TimerEvent": "launcher.language.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
