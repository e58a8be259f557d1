"""`launch.conditions.launch_configuration_not_equals`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchConfigurationNotEquals": "launcher.language.conditions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
