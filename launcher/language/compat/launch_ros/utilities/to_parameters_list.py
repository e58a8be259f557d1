"""`launch_ros.utilities.to_parameters_list`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "to_parameters_list": "launcher.language.ros.component_parameters",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
