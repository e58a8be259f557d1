"""`launch.actions.execute_process`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ExecuteProcess": "launcher.language.actions.process",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
