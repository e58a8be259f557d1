"""`launch.actions.log`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Log": "launcher.language.actions.logs",
    "LogDebug": "launcher.language.actions.logs",
    "LogError": "launcher.language.actions.logs",
    "LogInfo": "launcher.language.actions.events",
    "LogWarning": "launcher.language.actions.logs",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
