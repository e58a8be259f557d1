"""`launch.launch_service`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchService": "launcher.language.service",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
