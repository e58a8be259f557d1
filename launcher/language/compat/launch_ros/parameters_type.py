"""`launch_ros.parameters_type`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "EvaluatedParameterValue": "launcher.language.ros.some_types",
    "EvaluatedParameters": "launcher.language.ros.some_types",
    "MultiValueType": "launcher.language.ros.some_types",
    "ParameterFile": "launcher.language.ros.some_types",
    "ParameterName": "launcher.language.ros.some_types",
    "ParameterValue": "launcher.language.ros.some_types",
    "Parameters": "launcher.language.ros.some_types",
    "ParametersDict": "launcher.language.ros.some_types",
    "SingleValueType": "launcher.language.ros.some_types",
    "SomeParameterFile": "launcher.language.ros.some_types",
    "SomeParameterName": "launcher.language.ros.some_types",
    "SomeParameterValue": "launcher.language.ros.some_types",
    "SomeParameters": "launcher.language.ros.some_types",
    "SomeParametersDict": "launcher.language.ros.some_types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
