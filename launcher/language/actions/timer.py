"""TimerAction: visits entities after a delay."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable

from launcher.language import launch_session
from launcher.language.action import Action
from launcher.language.actions.event_actions import OpaqueFunction
from launcher.language.class_tools import ensure_argument_type, is_a_subclass
from launcher.language.diagnostics import ros2_quirks
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.events.base import EventHandler
from launcher.language.events.launch import Shutdown, TimerEvent
from launcher.language.frontend_registry import parsed
from launcher.language.future import Future
from launcher.language.launch_session import replace_environment
from launcher.language.naming import public, read_only
from launcher.language.substitution import Substitution
from launcher.language.type_utils import (
    normalize_typed_substitution,
    perform_typed_substitution,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.configurations import Configurations
    from launcher.language.context import LaunchContext


_INSTALLED = "_timer_event_handler_is_installed"


@public("launch.actions.timer_action")
@parsed
class TimerAction(Action):
    """Visits the actions once, `period` seconds after its own visit.

    The actions see the launch configurations of that visit, which hold the namespace, parameters
    and remappings of a group, and what they set ends with them. The environment is that of the
    moment at which the timer fires; in Lyrical, that of the visit. Without `cancel_on_shutdown` a
    shutdown waits for the timer and its actions, except that no process is started any more.
    """

    _is_on_ros_clock = False
    period: object = read_only("Seconds, or substitutions that give them.")
    actions: Any = read_only("The entities to visit when the timer fires.")

    def __init__(
        self,
        *,
        period: object,
        actions: Iterable[LaunchDescriptionEntity],
        cancel_on_shutdown: object = True,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        ensure_argument_type(period, [str, Substitution, Iterable, float], "period", "TimerAction")
        ensure_argument_type(actions, Iterable, "actions", "TimerAction")
        if isinstance(period, str):
            period = float(period)
            warnings.warn(
                "The parameter 'period' must be a float or substitution,"
                "passing a string literal was deprecated",
                stacklevel=2,
            )
        self.__period = normalize_typed_substitution(period, float)
        self.__actions = actions
        self.__cancel_on_shutdown = normalize_typed_substitution(cancel_on_shutdown, bool)
        self.__context_locals: dict[str, Any] = {}
        self._configurations: Configurations | None = None
        self.__environment: dict[str, str] | None = None
        self.__canceled = False
        self.__outlives_shutdown = False
        self.__timer_id: int | None = None
        self._context: LaunchContext | None = None
        self._completed_future: Future | None = None

    def describe(self) -> str:
        return f"TimerAction(period={self.__period}, actions=<actions>)"

    def describe_conditional_sub_entities(self) -> Any:
        return [(f"{self.__period} seconds pass without being canceled", self.__actions)]

    def handle(self, context: LaunchContext) -> Any:
        """Yield the actions, with the locals and configurations of the timer's own visit."""
        context.extend_locals(self.__context_locals)
        begin = TimerScopeBegin(self._configurations, self.__environment)
        return [begin, *self.__actions, TimerScopeEnd(self.__environment)]

    def cancel(self) -> None:
        """Cancel the timer; allowed at any time, also before it starts and after it fired."""
        self.__canceled = True
        if self._context is not None and self.__timer_id is not None:
            self._context._host.cancel_call(self.__timer_id)
            self.__timer_id = None
        if self._completed_future is not None:
            self._completed_future.set_result(None)

    def execute(self, context: LaunchContext) -> None:
        """Start the timer; its period is evaluated after the current event."""
        self._completed_future = Future()
        self._context = context
        if self.__canceled:
            self._completed_future.set_result(None)
            return
        _install_timer_event_handler(context)
        self.__context_locals = dict(context.get_locals_as_dict())
        self._configurations = context.launch_configurations.snapshot()
        if launch_session.current().is_like("lyrical"):
            self.__environment = dict(context.environment)
        context._host.later(lambda: self._start(context))
        self.__outlives_shutdown = not perform_typed_substitution(
            context, self.__cancel_on_shutdown, bool
        )
        if not self.__outlives_shutdown:
            _register(context, Shutdown, lambda context: self.cancel())

    def _start(self, context: LaunchContext) -> None:
        try:
            delay_s = perform_typed_substitution(context, self.__period, float)
        except Exception as error:
            # In ROS 2 the timer never fires and the launch hangs at its end.
            self._fail(context, error)
            return
        if not self.__canceled:
            self.__timer_id = context._host.call_later(
                max(0.0, delay_s),
                lambda: self._fire(context),
                outlives_shutdown=self.__outlives_shutdown,
                on_ros_clock=self._is_on_ros_clock,
                action=self,
            )

    def _fail(self, context: LaunchContext, error: Exception) -> None:
        text = f"the timer never fires: its period is not a number: {error}"
        context._host.log("launch.actions.timer_action", "ERROR", text)
        context._host.warn_quirk(text, self._origin)
        assert self._completed_future is not None
        self._completed_future.set_result(None)

    def _fire(self, context: LaunchContext) -> None:
        self.__timer_id = None
        context.emit_event_sync(TimerEvent(timer_action=self))
        assert self._completed_future is not None
        self._completed_future.set_result(None)

    def get_asyncio_future(self) -> Any:
        """Done when the timer has fired or was cancelled."""
        return self._completed_future


class TimerScopeBegin(Action):
    """Makes the configurations, and the environment if one is given, those of a timer's visit."""

    def __init__(
        self, configurations: Configurations | None, environment: dict[str, str] | None
    ) -> None:
        super().__init__()
        self._configurations = configurations
        self._environment = environment

    def execute(self, context: LaunchContext) -> None:
        context._push_launch_configurations(self._configurations)
        if self._environment is not None:
            context._push_environment()
            replace_environment(self._environment)


class TimerScopeEnd(Action):
    """Undoes what TimerScopeBegin, and the actions since then, have set."""

    def __init__(self, environment: dict[str, str] | None) -> None:
        super().__init__()
        self._environment = environment

    def execute(self, context: LaunchContext) -> None:
        if self._environment is not None:
            context._pop_environment()
        context._pop_launch_configurations()


def _install_timer_event_handler(context: LaunchContext) -> None:
    # With the first timer, not earlier: later handlers take precedence.
    if hasattr(context, _INSTALLED):
        return
    _register(
        context, TimerEvent, lambda context: context.locals.event.timer_action.handle(context)
    )
    setattr(context, _INSTALLED, True)


def _register(context: LaunchContext, kind: type, function: Callable[..., Any]) -> None:
    """Call the function for events of this class."""
    handler = EventHandler(
        matcher=lambda event: is_a_subclass(event, kind),
        entities=[OpaqueFunction(function=function)],
    )
    handler._expects(kind)
    context.register_event_handler(handler)


@public("launch_ros.actions.ros_timer")
@parsed
class RosTimer(TimerAction):
    """Like TimerAction, but on the ROS clock, which SetUseSimTime makes that of a simulation.

    Unlike there, a text as period is an error.
    """

    _is_on_ros_clock = True

    def __init__(
        self, *, period: object, actions: Iterable[LaunchDescriptionEntity], **kwargs: object
    ) -> None:
        super().__init__(period=period, actions=actions, **kwargs)
        self.__period = normalize_typed_substitution(period, float)

    def execute(self, context: LaunchContext) -> None:
        super().execute(context)
        parameters = context.launch_configurations.peek("global_params") or ()
        if ("use_sim_time", True) in parameters:
            # SetUseSimTime may follow in the same event.
            context._host.later(lambda: ros2_quirks.timer_is_on_wall_time(context, self._origin))

    def describe(self) -> str:
        return f"RosTimer(period={self.__period}, actions=<actions>)"
