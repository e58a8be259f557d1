"""`launch_ros.utilities.normalize_remap_rule`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "normalize_remap_rule": "launcher.language.ros.remappings",
    "normalize_remap_rules": "launcher.language.ros.remappings",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
