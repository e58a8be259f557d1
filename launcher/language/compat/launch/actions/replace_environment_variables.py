"""`launch.actions.replace_environment_variables`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ReplaceEnvironmentVariables": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
