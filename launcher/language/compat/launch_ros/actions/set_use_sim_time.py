"""`launch_ros.actions.set_use_sim_time`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetUseSimTime": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
