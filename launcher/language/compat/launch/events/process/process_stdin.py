"""`launch.events.process.process_stdin`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ProcessStdin": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
