"""`launch.launch_description_sources.python_launch_description_source`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "PythonLaunchDescriptionSource": "launcher.language.sources",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
