"""`launch.descriptions.executable`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Executable": "launcher.language.executable",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
