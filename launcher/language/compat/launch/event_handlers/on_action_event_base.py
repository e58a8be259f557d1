"""`launch.event_handlers.on_action_event_base`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnActionEventBase": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
