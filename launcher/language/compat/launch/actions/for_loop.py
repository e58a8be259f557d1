"""`launch.actions.for_loop`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ForEach": "launcher.language.actions.loops",
    "ForLoop": "launcher.language.actions.loops",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
