"""`launch.actions.execute_local`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ExecuteLocal": "launcher.language.actions.process",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
