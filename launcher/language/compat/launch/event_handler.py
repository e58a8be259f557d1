"""`launch.event_handler`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "BaseEventHandler": "launcher.language.event_handler",
    "EventHandler": "launcher.language.event_handler",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
