"""Type aliases that the public API offers for parameters and remappings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

from launcher.language.ros.node_and_topic_names import RemapRule
from launcher.language.ros.parameter_descriptions import Parameter
from launcher.language.ros.parameter_descriptions import ParameterFile as ParameterFileDescription
from launcher.language.ros.parameter_descriptions import ParameterValue as ValueDescription
from launcher.language.some_types import SomeSubstitutionsType
from launcher.language.substitution import Substitution

SingleValueType = Union[str, int, float, bool]
MultiValueType = Union[Sequence[str], Sequence[int], Sequence[float], Sequence[bool], bytes]

SomeParameterFile = Union[SomeSubstitutionsType, "os.PathLike[str]"]
SomeParameterName = Sequence[Union[Substitution, str]]
SomeParameterValue = Union[ValueDescription, SomeSubstitutionsType, SingleValueType, MultiValueType]
SomeParametersDict = Mapping[Any, Any]
SomeParameters = Sequence[Union[SomeParameterFile, Parameter, SomeParametersDict]]

ParameterFile = ParameterFileDescription
ParameterName = Sequence[Substitution]
ParameterValue = Union[Sequence[Substitution], SingleValueType, MultiValueType, ValueDescription]
ParametersDict = dict[ParameterName, ParameterValue]
Parameters = Sequence[Union[ParameterFile, Parameter, ParametersDict]]

EvaluatedParameterValue = Union[SingleValueType, MultiValueType]
EvaluatedParameters = Sequence[Union["os.PathLike[str]", Parameter, dict[str, Any]]]

RemapRules = Sequence[RemapRule]
SomeRemapRule = tuple[SomeSubstitutionsType, SomeSubstitutionsType]
SomeRemapRules = Sequence[SomeRemapRule]

__all__ = ["RemapRule"]
