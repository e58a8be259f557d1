"""`launch_ros.utilities.track_node_names`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "add_node_name": "launcher.language.ros.tracking",
    "get_node_name_count": "launcher.language.ros.tracking",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
