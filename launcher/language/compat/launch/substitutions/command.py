"""`launch.substitutions.command`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Command": "launcher.language.substitutions.command",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
