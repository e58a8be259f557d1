"""`launch.actions.reset_launch_configurations`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ResetLaunchConfigurations": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
