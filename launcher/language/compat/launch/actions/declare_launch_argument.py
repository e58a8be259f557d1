"""`launch.actions.declare_launch_argument`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "DeclareLaunchArgument": "launcher.language.actions.arguments",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
