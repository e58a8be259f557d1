"""`launch_ros.events.lifecycle.state_transition`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "StateTransition": "launcher.language.ros.lifecycle",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
