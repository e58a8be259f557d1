"""`launch.logging.handlers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "FileHandler": "logging",
    "Handler": "logging",
    "MemoryHandler": "logging.handlers",
    "NullHandler": "logging",
    "QueueHandler": "logging.handlers",
    "RotatingFileHandler": "logging.handlers",
    "SocketHandler": "logging.handlers",
    "StreamHandler": "logging",
    "SysLogHandler": "logging.handlers",
    "TimedRotatingFileHandler": "logging.handlers",
    "WatchedFileHandler": "logging.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
