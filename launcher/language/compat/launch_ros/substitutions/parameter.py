"""`launch_ros.substitutions.parameter`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Parameter": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
