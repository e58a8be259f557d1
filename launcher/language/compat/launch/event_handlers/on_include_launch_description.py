"""`launch.event_handlers.on_include_launch_description`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnIncludeLaunchDescription": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
