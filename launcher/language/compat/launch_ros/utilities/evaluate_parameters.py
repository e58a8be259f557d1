"""`launch_ros.utilities.evaluate_parameters`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "evaluate_parameter_dict": "launcher.language.ros.parameter_values",
    "evaluate_parameters": "launcher.language.ros.parameter_values",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
