"""`launch.logging`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchConfig": "launcher.language.log",
    "LaunchLogger": "launcher.language.log",
    "get_logger": "launcher.language.log",
    "get_output_loggers": "launcher.language.log",
    "launch_config": "launcher.language.log",
    "log_launch_config": "launcher.language.log",
    "reset": "launcher.language.log",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
