"""`launch.launch_description_sources.frontend_launch_description_source`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "FrontendLaunchDescriptionSource": "launcher.language.sources",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
