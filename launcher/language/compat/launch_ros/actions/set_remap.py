"""`launch_ros.actions.set_remap`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetRemap": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
