"""`launch_ros.actions.load_composable_nodes`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LoadComposableNodes": "launcher.language.ros.composition",
    "get_composable_node_load_request": "launcher.language.ros.composition",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
