"""`launch.substitutions.environment_variable`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "EnvironmentVariable": "launcher.language.substitutions.environment",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
