"""`launch.conditions.launch_configuration_equals`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchConfigurationEquals": "launcher.language.conditions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
