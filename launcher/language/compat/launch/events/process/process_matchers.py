"""`launch.events.process.process_matchers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "matches_executable": "launcher.language.process_events",
    "matches_name": "launcher.language.process_events",
    "matches_pid": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
