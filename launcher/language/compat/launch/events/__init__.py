"""`launch.events`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ExecutionComplete": "launcher.language.events",
    "IncludeLaunchDescription": "launcher.language.events",
    "Shutdown": "launcher.language.events",
    "TimerEvent": "launcher.language.events",
    "matches_action": "launcher.language.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
