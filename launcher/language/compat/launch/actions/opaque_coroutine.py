"""`launch.actions.opaque_coroutine`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OpaqueCoroutine": "launcher.language.actions.coroutine",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
