"""`launch.actions.group_action`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "GroupAction": "launcher.language.actions.group",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
