"""`launch_ros.remap_rule_type`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "RemapRule": "launcher.language.ros.some_types",
    "RemapRules": "launcher.language.ros.some_types",
    "SomeRemapRule": "launcher.language.ros.some_types",
    "SomeRemapRules": "launcher.language.ros.some_types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
