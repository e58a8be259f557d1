"""Events of the launch itself."""

from __future__ import annotations

from collections.abc import Callable

from launcher.language.events.base import Event
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@public("launch.events.execution_complete")
class ExecutionComplete(Event):
    """An action was executed and has finished."""

    name = "launch.events.ExecutionComplete"
    action: Any = read_only()

    def __init__(self, *, action: Any) -> None:
        self.__action = action


@public("launch.events.include_launch_description")
class IncludeLaunchDescription(Event):
    """A launch description is to be visited."""

    name = "launch.events.IncludeLaunchDescription"

    def __init__(self, launch_description: object) -> None:
        self.launch_description = launch_description


@public("launch.events.shutdown")
class Shutdown(Event):
    """The launched system is to be stopped."""

    name = "launch.events.Shutdown"
    reason: str = read_only()
    due_to_sigint: bool = read_only()

    def __init__(self, *, reason: str = "reason not given", due_to_sigint: bool = False) -> None:
        self.__reason = reason
        self.__due_to_sigint = due_to_sigint


@public("launch.events.timer_event")
class TimerEvent(Event):
    """A timer fired."""

    name = "launch.events.TimerEvent"
    timer_action: object = read_only()

    def __init__(self, *, timer_action: object) -> None:
        self.__timer_action = timer_action


def matches_action(target_action: object) -> Callable[[Any], bool]:
    """A matcher for exactly this action."""
    return lambda action: action is target_action
