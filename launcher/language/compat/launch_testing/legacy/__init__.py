"""`launch_testing.legacy`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchTestService": "launcher.language.testing",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
