"""Type aliases that the public API offers for entities, substitutions and paths."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, List, Sequence, Type, Union  # noqa: UP035

from launcher.language.action import Action
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.substitution import Substitution
from launcher.language.type_utils import ScalarTypesTuple

SomeSubstitutionsType = Union[str, Substitution, Iterable[Union[str, Substitution]]]
FilePath = Union[bytes, str, "os.PathLike[str]"]
SomeEntitiesType = Union[LaunchDescriptionEntity, Iterable[LaunchDescriptionEntity]]
SomeEntitiesType_types_tuple = (LaunchDescriptionEntity, Iterable)
SomeActionsType = Union[LaunchDescriptionEntity, Action, Iterable[LaunchDescriptionEntity]]
SomeActionsType_types_tuple = (LaunchDescriptionEntity, Action, Iterable)


ListTypesTuple = (List[int], List[float], List[bool], List[str])  # noqa: UP006
AllowedTypesTuple = ScalarTypesTuple + ListTypesTuple

ScalarTypesType = Type[Union[int, float, bool, str]]  # noqa: UP006
ListTypesType = Any
AllowedTypesType = Any
ScalarValueType = Union[int, float, bool, str]
ListValueType = Union[List[int], List[float], List[bool], List[str]]  # noqa: UP006
SequenceValueType = Union[Sequence[int], Sequence[float], Sequence[bool], Sequence[str]]
AllowedValueType = Union[ScalarValueType, SequenceValueType]
SomeScalarType = Union[SomeSubstitutionsType, ScalarValueType]
SomeSequenceType = Sequence[Union[ScalarValueType, SomeSubstitutionsType]]
SomeValueType = Union[SomeScalarType, SomeSequenceType]
NormalizedScalarType = Union[List[Substitution], ScalarValueType]  # noqa: UP006
NormalizedSequenceType = List[Union[ScalarValueType, List[Substitution]]]  # noqa: UP006
NormalizedValueType = Union[NormalizedScalarType, NormalizedSequenceType]
StrSomeScalarType = SomeScalarType
StrSomeSequenceType = Sequence[ScalarValueType]
StrSomeValueType = Union[StrSomeScalarType, StrSomeSequenceType]
