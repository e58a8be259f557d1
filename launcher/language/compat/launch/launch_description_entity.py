"""`launch.launch_description_entity`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchDescriptionEntity": "launcher.language.entity",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
