"""`launch_ros.parameters_type`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.some_types import (
    EvaluatedParameters,
    EvaluatedParameterValue,
    MultiValueType,
    ParameterFile,
    ParameterName,
    Parameters,
    ParametersDict,
    ParameterValue,
    SingleValueType,
    SomeParameterFile,
    SomeParameterName,
    SomeParameters,
    SomeParametersDict,
    SomeParameterValue,
)

__all__ = [
    "EvaluatedParameterValue",
    "EvaluatedParameters",
    "MultiValueType",
    "ParameterFile",
    "ParameterName",
    "ParameterValue",
    "Parameters",
    "ParametersDict",
    "SingleValueType",
    "SomeParameterFile",
    "SomeParameterName",
    "SomeParameterValue",
    "SomeParameters",
    "SomeParametersDict",
]

__getattr__ = refuse_unknown("launch_ros.parameters_type", __all__)
