"""`launch_ros.actions.set_parameters_from_file`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SetParametersFromFile": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
