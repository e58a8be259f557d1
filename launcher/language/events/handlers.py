"""Event handlers for actions, includes and shutdown; those of processes are in actions.process."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from launcher.language.action import Action
from launcher.language.class_tools import is_a_subclass
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.events.base import BaseEventHandler, Event, EventHandler
from launcher.language.events.launch import ExecutionComplete, IncludeLaunchDescription, Shutdown
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.event_handlers.on_action_event_base")
class OnActionEventBase(BaseEventHandler):
    """Base of handlers of events that have an `action`; `on_event` is entities or a callable."""

    def __init__(
        self,
        *,
        action_matcher: object,
        on_event: object,
        target_event_cls: type[Event],
        target_action_cls: type,
        **kwargs: Any,
    ) -> None:
        if not issubclass(target_event_cls, Event):
            raise TypeError("'target_event_cls' must be a subclass of 'Event'")
        known = action_matcher is None or isinstance(action_matcher, target_action_cls)
        if not known and not callable(action_matcher):
            raise TypeError(
                f"action_matcher must be an '{target_action_cls.__name__}' instance or a callable"
            )
        self.__target_action_cls = target_action_cls
        self.__target_event_cls = target_event_cls
        self.__action_matcher = action_matcher
        super().__init__(matcher=self.__is_target, **kwargs)
        self._expects(target_event_cls)
        self.__on_event = on_event if callable(on_event) else None
        self.__actions_on_event: list[Any] = [] if callable(on_event) else _entities(on_event)
        self._function_called = self.__on_event  # for messages

    def __is_target(self, event: Event) -> bool:
        if not isinstance(event, self.__target_event_cls):
            return False
        action = event.action  # type: ignore[attr-defined]  # every target event has one
        matcher = self.__action_matcher
        if callable(matcher):  # also an action that defines `__call__`
            return bool(matcher(action))
        return matcher is None or action is matcher

    @property
    def handler_description(self) -> str:
        return "<actions>" if self.__actions_on_event else f"{self.__on_event}"

    @property
    def matcher_description(self) -> str:
        text = f"event == {self.__target_event_cls.__name__}"
        if self.__action_matcher is None:
            return text
        return f"{text} and {self.__target_action_cls.__name__}(event.action)"

    def describe(self) -> tuple[str, list[LaunchDescriptionEntity]]:
        text, actions = super().describe()
        return (text, [*actions, *self.__actions_on_event])

    def handle(self, event: Event, context: LaunchContext) -> Any:
        """Yield the entities, or what the callable returns."""
        super().handle(event, context)
        if self.__actions_on_event:
            return self.__actions_on_event
        if self.__on_event is None:
            return None
        return self.__on_event(event, context)


def _entities(on_event: object) -> list[Any]:
    if not isinstance(on_event, Iterable):
        return [on_event]
    entities = list(on_event)
    for entity in entities:
        if not isinstance(entity, LaunchDescriptionEntity):
            raise TypeError(
                "expected all items in 'on_event' iterable to be of type "
                f"'LaunchDescriptionEntity' but got '{type(entity)}'"
            )
    return entities


@public("launch.event_handlers.on_execution_complete")
class OnExecutionComplete(OnActionEventBase):
    """Reacts when an action was executed and has ended."""

    def __init__(
        self, *, target_action: object = None, on_completion: object, **kwargs: object
    ) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_completion,
            target_event_cls=ExecutionComplete,
            target_action_cls=Action,
            **kwargs,
        )


@public("launch.event_handlers.on_shutdown")
class OnShutdown(BaseEventHandler):
    """Reacts when the launched system is to be stopped."""

    def __init__(self, *, on_shutdown: object, **kwargs: Any) -> None:
        super().__init__(matcher=lambda event: is_a_subclass(event, Shutdown), **kwargs)
        self._expects(Shutdown)
        self.__on_shutdown = on_shutdown
        self._function_called = on_shutdown if callable(on_shutdown) else None  # for messages

    @property
    def handler_description(self) -> str:
        return f"{self.__on_shutdown}"

    @property
    def matcher_description(self) -> str:
        return "event issubclass of launch.events.Shutdown"

    def handle(self, event: Event, context: LaunchContext) -> Any:
        """Yield the entities, or what the callable returns."""
        super().handle(event, context)
        if callable(self.__on_shutdown):
            return self.__on_shutdown(event, context)
        return self.__on_shutdown


@public("launch.event_handlers.on_include_launch_description")
class OnIncludeLaunchDescription(BaseEventHandler):
    """Yields the launch description of the event; every run has one of these."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(
            matcher=lambda event: is_a_subclass(event, IncludeLaunchDescription), **kwargs
        )
        self._expects(IncludeLaunchDescription)

    @property
    def handler_description(self) -> str:
        return "returns the launch_description in the event"

    @property
    def matcher_description(self) -> str:
        return "event issubclass of launch.events.IncludeLaunchDescription"

    def handle(self, event: Event, context: LaunchContext) -> Any:
        super().handle(event, context)
        assert isinstance(event, IncludeLaunchDescription)
        return event.launch_description


class TargetedHandler(EventHandler):
    """Calls `callback(event, context)` for events of the class `kind`."""

    def __init__(self, kind: type, callback: Any) -> None:
        super().__init__(matcher=lambda event: isinstance(event, kind))
        self._expects(kind)
        self._callback = callback

    def handle(self, event: Any, context: LaunchContext) -> Any:
        super().handle(event, context)
        return self._callback(event, context)


def event_named(name: str) -> Callable[[Event], bool]:
    """A matcher for events whose class has this `name`."""
    return lambda event: event.name == name
