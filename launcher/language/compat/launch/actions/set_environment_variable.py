"""`launch.actions.set_environment_variable`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetEnvironmentVariable": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
