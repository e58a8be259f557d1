"""`launch.event_handlers.on_process_exit`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnProcessExit": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
