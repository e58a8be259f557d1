"""`launch.actions.set_launch_configuration`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetLaunchConfiguration": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
