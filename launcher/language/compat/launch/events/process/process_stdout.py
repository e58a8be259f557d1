"""`launch.events.process.process_stdout`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ProcessStdout": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
