"""`launch.substitutions.this_launch_file`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ThisLaunchFile": "launcher.language.substitutions.files",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
