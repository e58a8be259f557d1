"""`launch_ros.descriptions.ros_executable`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "RosExecutable": "launcher.language.ros.executable",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
