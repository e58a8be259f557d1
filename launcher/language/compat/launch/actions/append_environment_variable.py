"""`launch.actions.append_environment_variable`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AppendEnvironmentVariable": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
