"""`launch.invalid_launch_file_error`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "InvalidLaunchFileError": "launcher.language.sources",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
