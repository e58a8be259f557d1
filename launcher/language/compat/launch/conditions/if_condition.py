"""`launch.conditions.if_condition`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "IfCondition": "launcher.language.conditions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
