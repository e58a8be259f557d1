"""`launch.logging.handlers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "StreamHandler": "launcher.language.log:SessionHandler",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
