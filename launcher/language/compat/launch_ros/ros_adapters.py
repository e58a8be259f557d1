"""`launch_ros.ros_adapters`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ROSAdapter": "launcher.language.ros.adapters",
    "get_ros_adapter": "launcher.language.ros.adapters",
    "get_ros_node": "launcher.language.ros.adapters",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
