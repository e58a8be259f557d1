"""`launch.actions.reset_environment`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ResetEnvironment": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
