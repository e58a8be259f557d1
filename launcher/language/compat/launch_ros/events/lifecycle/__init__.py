"""`launch_ros.events.lifecycle`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ChangeState": "launcher.language.ros.lifecycle",
    "StateTransition": "launcher.language.ros.lifecycle",
    "matches_node_name": "launcher.language.ros.lifecycle",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
