"""RosTimer: a timer on ROS time."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language import frontend_registry
from launcher.language.actions.timer import TimerAction
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.naming import public
from launcher.language.type_utils import normalize_typed_substitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@public("launch_ros.actions.ros_timer")
class RosTimer(TimerAction):
    """Like TimerAction; unlike there, a text as period is an error."""

    def __init__(
        self, *, period: Any, actions: Iterable[LaunchDescriptionEntity], **kwargs: Any
    ) -> None:
        super().__init__(period=period, actions=actions, **kwargs)
        self.__period = normalize_typed_substitution(period, float)

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> Any:
        """(class, keyword arguments) of an XML or YAML entity."""
        return frontend_registry.parse_with("RosTimer", cls, entity, parser)

    def describe(self) -> str:
        """Like `RosTimer(period=5.0, actions=<actions>)`."""
        return f"RosTimer(period={self.__period}, actions=<actions>)"
