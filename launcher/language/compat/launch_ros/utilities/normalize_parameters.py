"""`launch_ros.utilities.normalize_parameters`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "normalize_parameter_dict": "launcher.language.ros.parameter_values",
    "normalize_parameters": "launcher.language.ros.parameter_values",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
