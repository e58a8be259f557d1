"""`launch.actions.log_info`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LogInfo": "launcher.language.actions.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
