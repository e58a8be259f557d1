"""`launch.frontend.entity`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Entity": "launcher.frontends.entity",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
