"""`launch_testing`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "parametrize": "launcher.language.testing",
    "post_shutdown_test": "launcher.language.testing",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
