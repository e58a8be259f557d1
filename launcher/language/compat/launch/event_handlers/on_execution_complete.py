"""`launch.event_handlers.on_execution_complete`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnExecutionComplete": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
