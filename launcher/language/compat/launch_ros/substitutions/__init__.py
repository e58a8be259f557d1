"""`launch_ros.substitutions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ExecutableInPackage": "launcher.language.ros.packages",
    "FindPackage": "launcher.language.ros.packages",
    "FindPackagePrefix": "launcher.language.ros.packages",
    "FindPackageShare": "launcher.language.ros.packages",
    "Parameter": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
