"""`launch_ros.descriptions.node`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Node": "launcher.language.ros.node_descriptions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
