"""Actions that emit events, register handlers, and call functions of the launch file."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from launcher.language import launch_session
from launcher.language.action import Action
from launcher.language.class_tools import ensure_argument_type, is_a_subclass
from launcher.language.diagnostics import ros2_quirks
from launcher.language.events.base import BaseEventHandler, Event
from launcher.language.events.launch import Shutdown as ShutdownEvent
from launcher.language.events.process import ProcessExited
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.entity import LaunchDescriptionEntity


@public("launch.actions.emit_event")
class EmitEvent(Action):
    """Emits an event."""

    event: Event = read_only()

    def __init__(self, *, event: Event, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        if not is_a_subclass(event, Event):
            raise RuntimeError(
                f"EmitEvent() expected an event instance, got '{event}' ({type(event)})"
            )
        self.__event = event

    def execute(self, context: LaunchContext) -> None:
        context.emit_event_sync(self.__event)


@public("launch.actions.shutdown_action")
@parsed
class Shutdown(EmitEvent):
    """Stops the launched system."""

    def __init__(self, *, reason: Any = "reason not given", **kwargs: Any) -> None:
        super().__init__(event=ShutdownEvent(reason=reason), **kwargs)

    def execute(self, context: LaunchContext) -> None:
        """Emit the event; log which required process exited if that led here."""
        event = context.get_locals_as_dict().get("event")
        if isinstance(event, ProcessExited):
            text = f"process[{event.process_name}] was required: shutting down launched system"
            context._host.log("launch", "INFO", text)
        reason = getattr(self.event, "reason", None)
        if isinstance(reason, (Substitution, list)):  # of XML and YAML; the event has a text
            context.emit_event_sync(ShutdownEvent(reason=perform(context, reason)))
        else:
            super().execute(context)


# With the numbers of `logging`; messages from INFO on are left to the run.
_LEVELS = {
    "NOTSET": 0,
    "DEBUG": 10,
    "INFO": 20,
    "WARNING": 30,
    "WARN": 30,
    "ERROR": 40,
    "CRITICAL": 50,
    "FATAL": 50,
}


@public("launch.actions.log")
@parsed
class Log(Action):
    """Prints a message at a level: `INFO`, `WARNING`, `ERROR`, `CRITICAL`, with --debug `DEBUG`.

    Newer than Jazzy, as are its subclasses except LogInfo.
    """

    msg: list[Substitution] = read_only()
    level: list[Substitution] = read_only()

    def __init__(self, *, msg: object, level: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__msg = normalize_to_list_of_substitutions(msg)
        if isinstance(level, str):
            _check_level(level.upper())
        self.__level = normalize_to_list_of_substitutions(level)

    def execute(self, context: LaunchContext) -> None:
        """Log the message; KeyError if the level is none."""
        level = perform_substitutions(context, self.level).upper()
        _check_level(level)
        text = perform_substitutions(context, self.msg)
        if _LEVELS[level] >= min(launch_session.current().level, _LEVELS["INFO"]):
            level = launch_session.LEVEL_NAMES.get(level, level)
            context._host.log("launch.user", level, text)


def _check_level(level: str) -> None:
    if level not in _LEVELS:
        raise KeyError(f"Invalid log level '{level}', expected: {', '.join(_LEVELS)}")


class _LogAt(Log):
    """Base of those with a fixed level."""

    _level = ""

    def __init__(self, *, msg: object, **kwargs: object) -> None:
        super().__init__(msg=msg, level=self._level, **kwargs)


@public("launch.actions.log_info")
@parsed
class LogInfo(_LogAt):
    """Prints a message."""

    _level = "INFO"


@public("launch.actions.log")
class LogDebug(_LogAt):
    """Prints a debug message."""

    _level = "DEBUG"


@public("launch.actions.log")
class LogWarning(_LogAt):
    """Prints a warning."""

    _level = "WARNING"


@public("launch.actions.log")
class LogError(_LogAt):
    """Prints an error."""

    _level = "ERROR"


@public("launch.actions.opaque_function")
class OpaqueFunction(Action):
    """Calls a function with the context; the list of entities that it returns is visited."""

    _function_called: Callable[..., Any] = read_only(
        "The function whose result is visited, for messages.", of="__function"
    )

    def __init__(
        self,
        *,
        function: Callable[..., Any],
        args: Iterable[Any] | None = None,
        kwargs: dict[str, Any] | None = None,
        **left_over_kwargs: Any,
    ) -> None:
        super().__init__(**left_over_kwargs)
        if not callable(function):
            raise TypeError(
                f"OpaqueFunction expected a callable for 'function', got '{type(function)}'"
            )
        ensure_argument_type(args, (Iterable, type(None)), "args", "OpaqueFunction")
        ensure_argument_type(kwargs, (dict, type(None)), "kwargs", "OpaqueFunction")
        self.__function = function
        self.__args: list[Any] = [] if args is None else list(args)
        self.__kwargs: dict[str, Any] = {} if kwargs is None else kwargs

    def execute(self, context: LaunchContext) -> Any:
        entities = self.__function(context, *self.__args, **self.__kwargs)
        if entities is None and _makes_actions(self.__function):
            # Imported only for a possible mistake.
            from launcher.language.diagnostics.bad_entries import warn_of_forgotten_return

            warn_of_forgotten_return(self.__function, context)
        return entities


def _makes_actions(function: Any) -> bool:
    """Whether the code of a function names classes of actions."""
    known = getattr(function, "__globals__", {})
    named = [known.get(name) for name in function.__code__.co_names] if known else []
    return any(isinstance(one, type) and issubclass(one, Action) for one in named)


class _OfHandler(Action):
    """Base of actions on an event handler."""

    event_handler: BaseEventHandler = read_only()

    def __init__(self, event_handler: BaseEventHandler, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__event_handler = event_handler


@public("launch.actions.register_event_handler")
class RegisterEventHandler(_OfHandler):
    """Registers an event handler."""

    def execute(self, context: LaunchContext) -> None:
        ros2_quirks.scope_is_lost(context, self._origin)
        self.event_handler._origin = self._origin
        context.register_event_handler(self.event_handler)

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """The entities of the handler."""
        handler = self.event_handler
        if not (hasattr(handler, "describe") and hasattr(handler, "matches")):
            # Imported only for an error.
            from launcher.language.diagnostics.bad_entries import not_a_handler

            raise not_a_handler(handler, self)
        description: Any = handler.describe()
        try:
            return [(description[0], list(description[1]))]
        except (TypeError, LookupError):
            # Imported only for an error.
            from launcher.language.diagnostics.wrong_returns import wrong_return

            expected = "a text and a list of entities"
            raise wrong_return(handler, "describe", description, expected) from None


@public("launch.actions.unregister_event_handler")
class UnregisterEventHandler(_OfHandler):
    """Unregisters an event handler; ValueError if it is not registered."""

    def execute(self, context: LaunchContext) -> None:
        context.unregister_event_handler(self.event_handler)
