"""`launch_ros.descriptions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ComposableNode": "launcher.language.ros.composition",
    "Node": "launcher.language.ros.node_descriptions",
    "NodeTrait": "launcher.language.ros.node_descriptions",
    "Parameter": "launcher.language.ros.parameter_descriptions",
    "ParameterFile": "launcher.language.ros.parameter_descriptions",
    "ParameterValue": "launcher.language.ros.parameter_descriptions",
    "RosExecutable": "launcher.language.ros.executable",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
