"""`launch.substitutions.for_loop_var`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ForEachVar": "launcher.language.substitutions.names",
    "ForLoopIndex": "launcher.language.substitutions.names",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
