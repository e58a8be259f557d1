"""`launch.actions.include_launch_description`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "IncludeLaunchDescription": "launcher.language.actions.include",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
