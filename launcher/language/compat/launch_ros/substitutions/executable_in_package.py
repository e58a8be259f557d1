"""`launch_ros.substitutions.executable_in_package`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ExecutableInPackage": "launcher.language.ros.packages",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
