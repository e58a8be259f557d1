"""`launch_ros.events.lifecycle.change_state`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ChangeState": "launcher.language.ros.lifecycle",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
