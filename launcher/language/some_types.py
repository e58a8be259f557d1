"""Type aliases that the public API offers for entities."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Union

from launcher.language.action import Action
from launcher.language.entity import LaunchDescriptionEntity

SomeEntitiesType = Union[LaunchDescriptionEntity, Iterable[LaunchDescriptionEntity]]
SomeEntitiesType_types_tuple = (LaunchDescriptionEntity, Iterable)
SomeActionsType = Union[LaunchDescriptionEntity, Action, Iterable[LaunchDescriptionEntity]]
SomeActionsType_types_tuple = (LaunchDescriptionEntity, Action, Iterable)
