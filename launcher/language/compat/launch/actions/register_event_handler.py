"""`launch.actions.register_event_handler`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "RegisterEventHandler": "launcher.language.actions.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
