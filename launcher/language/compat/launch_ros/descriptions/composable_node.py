"""`launch_ros.descriptions.composable_node`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ComposableNode": "launcher.language.ros.composition",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
