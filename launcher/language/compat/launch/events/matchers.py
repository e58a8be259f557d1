"""`launch.events.matchers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "matches_action": "launcher.language.events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
