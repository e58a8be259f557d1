"""`launch_ros.utilities.namespace_utils`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "is_namespace_absolute": "launcher.language.ros.names",
    "is_root_namespace": "launcher.language.ros.names",
    "make_namespace_absolute": "launcher.language.ros.names",
    "prefix_namespace": "launcher.language.ros.names",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
