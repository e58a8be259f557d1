"""`launch.utilities.create_future_impl`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "create_future": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
