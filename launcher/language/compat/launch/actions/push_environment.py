"""`launch.actions.push_environment`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "PushEnvironment": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
