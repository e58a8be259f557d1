"""`launch.launch_context`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchContext": "launcher.language.context",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
