"""`launch_ros`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "get_default_launch_description": "launcher.language.ros.adapters",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
