"""`launch.actions.unregister_event_handler`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "UnregisterEventHandler": "launcher.language.actions.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
