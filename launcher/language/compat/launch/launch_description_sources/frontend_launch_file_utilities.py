"""`launch.launch_description_sources.frontend_launch_file_utilities`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "get_launch_description_from_frontend_launch_file": "launcher.language.sources",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
