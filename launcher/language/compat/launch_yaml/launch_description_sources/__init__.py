"""`launch_yaml.launch_description_sources`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "YAMLLaunchDescriptionSource": "launcher.language.sources",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
