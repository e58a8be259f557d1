"""`launch_ros.event_handlers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnStateTransition": "launcher.language.ros.lifecycle",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
