"""`launch_ros.actions.node`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Node": "launcher.language.ros.node",
    "NodeActionExtension": "launcher.language.ros.node",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
