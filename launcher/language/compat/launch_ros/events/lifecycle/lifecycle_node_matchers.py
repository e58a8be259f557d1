"""`launch_ros.events.lifecycle.lifecycle_node_matchers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "matches_node_name": "launcher.language.ros.lifecycle",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
