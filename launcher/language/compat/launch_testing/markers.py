"""`launch_testing.markers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "keep_alive": "launcher.language.testing",
    "retry_on_failure": "launcher.language.testing",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
