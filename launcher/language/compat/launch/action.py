"""`launch.action`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Action": "launcher.language.action",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
