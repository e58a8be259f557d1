"""`launch_ros.substitutions.find_package`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "FindPackage": "launcher.language.ros.packages",
    "FindPackagePrefix": "launcher.language.ros.packages",
    "FindPackageShare": "launcher.language.ros.packages",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
