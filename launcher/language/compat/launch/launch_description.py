"""`launch.launch_description`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchDescription": "launcher.language.description",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
