"""`launch_testing.util`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "KeepAliveProc": "launcher.language.testing",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
