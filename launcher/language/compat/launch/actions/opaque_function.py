"""`launch.actions.opaque_function`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OpaqueFunction": "launcher.language.actions.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
