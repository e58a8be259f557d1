"""`launch_ros.actions.set_parameter`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetParameter": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
