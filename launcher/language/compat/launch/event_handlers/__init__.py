"""`launch.event_handlers`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "OnActionEventBase": "launcher.language.handlers",
    "OnExecutionComplete": "launcher.language.handlers",
    "OnIncludeLaunchDescription": "launcher.language.handlers",
    "OnProcessExit": "launcher.language.handlers",
    "OnProcessIO": "launcher.language.handlers",
    "OnProcessStart": "launcher.language.handlers",
    "OnShutdown": "launcher.language.handlers",
    "event_named": "launcher.language.handlers",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
