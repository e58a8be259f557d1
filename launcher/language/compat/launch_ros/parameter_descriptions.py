"""`launch_ros.parameter_descriptions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "Parameter": "launcher.language.ros.parameter_descriptions",
    "ParameterFile": "launcher.language.ros.parameter_descriptions",
    "ParameterValue": "launcher.language.ros.parameter_descriptions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
