"""`launch.substitutions.launch_configuration`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchConfiguration": "launcher.language.substitutions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
