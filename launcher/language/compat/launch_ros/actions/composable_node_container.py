"""`launch_ros.actions.composable_node_container`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ComposableNodeContainer": "launcher.language.ros.composition",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
