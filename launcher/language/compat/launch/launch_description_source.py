"""`launch.launch_description_source`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchDescriptionSource": "launcher.language.sources",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
