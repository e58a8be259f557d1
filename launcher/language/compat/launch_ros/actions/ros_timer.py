"""`launch_ros.actions.ros_timer`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ROSTimer": "launcher.language.ros.timer:RosTimer",
    "RosTimer": "launcher.language.ros.timer",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
