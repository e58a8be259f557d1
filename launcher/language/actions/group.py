"""GroupAction: entities with a common scope and a common condition."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from launcher.language.action import Action
from launcher.language.actions.configuration import (
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetLaunchConfiguration,
)
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.entity import LaunchDescriptionEntity


@public("launch.actions.group_action")
@parsed
class GroupAction(Action):
    """Yields its actions.

    `scoped`: changes of launch configurations and environment end with the group;
    `forwarding`: inside, those from outside are visible; `launch_configurations` are set first
    (and, without forwarding, are all that there is).
    """

    _entries_written: Iterable[Any] = read_only(
        "The actions as they stand in the launch file, for messages.", of="__actions"
    )

    def __init__(
        self,
        actions: Iterable[Action],
        *,
        scoped: bool = True,
        forwarding: bool = True,
        launch_configurations: Mapping[Any, Any] | None = None,
        **left_over_kwargs: Any,
    ) -> None:
        super().__init__(**left_over_kwargs)
        self.__actions = actions
        self.__scoped = scoped
        self.__forwarding = forwarding
        self.__launch_configurations = launch_configurations or {}
        self.__actions_to_return: list[LaunchDescriptionEntity] | None = None

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """The actions, with those around them that make the scope."""
        if self.__actions_to_return is None:
            opening = self._opening()
            for one in opening:
                one._origin = self._origin
            self.__actions_to_return = [*opening, *self.__actions, *self._closing()]
        return self.__actions_to_return

    def _opening(self) -> list[LaunchDescriptionEntity]:
        sets = [SetLaunchConfiguration(k, v) for k, v in self.__launch_configurations.items()]
        if not self.__scoped:
            return [*sets]
        if self.__forwarding:
            return [PushLaunchConfigurations(), PushEnvironment(), *sets]
        return [
            PushLaunchConfigurations(),
            PushEnvironment(),
            ResetEnvironment(),
            ResetLaunchConfigurations(self.__launch_configurations),
        ]

    def _closing(self) -> list[LaunchDescriptionEntity]:
        return [PopEnvironment(), PopLaunchConfigurations()] if self.__scoped else []

    def execute(self, context: LaunchContext) -> Any:
        return self.get_sub_entities()
