"""`launch.events.execution_complete`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ExecutionComplete": "launcher.language.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
