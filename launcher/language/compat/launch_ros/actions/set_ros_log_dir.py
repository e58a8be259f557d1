"""`launch_ros.actions.set_ros_log_dir`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetROSLogDir": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
