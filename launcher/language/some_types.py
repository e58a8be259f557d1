"""Type aliases that the public API offers for entities, substitutions and paths."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Union

from launcher.language.action import Action
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.substitution import Substitution

SomeSubstitutionsType = Union[str, Substitution, Iterable[Union[str, Substitution]]]
FilePath = Union[bytes, str, "os.PathLike[str]"]
SomeEntitiesType = Union[LaunchDescriptionEntity, Iterable[LaunchDescriptionEntity]]
SomeEntitiesType_types_tuple = (LaunchDescriptionEntity, Iterable)
SomeActionsType = Union[LaunchDescriptionEntity, Action, Iterable[LaunchDescriptionEntity]]
SomeActionsType_types_tuple = (LaunchDescriptionEntity, Action, Iterable)
