"""Lifecycle nodes: start, transition requests, transition events."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from types import SimpleNamespace

from launcher.base.model import lifecycle_transitions
from launcher.base.model.events import (
    StateChanged,
    StateRequest,
    TransitionSeen,
    WatchLifecycle,
)
from launcher.language.action import Action
from launcher.language.actions.event_actions import EmitEvent, OpaqueFunction, RegisterEventHandler
from launcher.language.events.base import Event, EventHandler
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.ros.node import Node
from launcher.language.substitution import normalize_to_list_of_substitutions, perform_substitutions
from launcher.language.type_utils import (
    normalize_typed_substitution,
    perform_typed_substitution,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_LOGGER = "launch_ros.utilities.lifecycle_event_manager"
_CONFIGURE, _ACTIVATE = 1, 3  # numbers of transitions
_SECOND = 10**9  # in ns
_NO_LIFECYCLE = (
    "OnStateTransition requires a lifecycle enabled node as the target, target_lifecycle_node is "
    "not lifecycle-enabled."
)
_NO_NODE = (
    "OnStateTransition requires a lifecycle enabled node as the target, target_lifecycle_node is "
    "not a lifecycle-enabled node type."
)


@public("launch_ros.events.lifecycle.change_state")
class ChangeState(Event):
    """Requests a transition of the lifecycle nodes that the matcher selects."""

    name = "launch_ros.events.lifecycle.ChangeState"
    valid_transitions = OrderedDict(
        (number, transition.constant)
        for number, transition in lifecycle_transitions.TRANSITIONS.items()
    )
    valid_states = OrderedDict(lifecycle_transitions.STATES)
    lifecycle_node_matcher: Callable[[Any], bool] = read_only("Called with a LifecycleNode action.")
    transition_id: int = read_only("A constant of lifecycle_msgs/msg/Transition.")

    def __init__(
        self, *, lifecycle_node_matcher: Callable[[Any], bool], transition_id: int
    ) -> None:
        self.__lifecycle_node_matcher = lifecycle_node_matcher
        self.__transition_id = transition_id
        if transition_id not in self.valid_transitions:
            pairs = self.valid_transitions.items()
            known = ", ".join(f"{name}: {number}" for number, name in pairs)
            raise ValueError(
                f"given transition_id of '{transition_id}', expected one of {{{known}}}"
            )


@public("launch_ros.events.lifecycle.state_transition")
class StateTransition(Event):
    """A lifecycle node went from one state to another."""

    name = "launch_ros.events.lifecycle.StateTransition"
    action: Any = read_only("The LifecycleNode, or the description of a composable node.")
    msg: Any = read_only(
        "The message of the node, with the fields of lifecycle_msgs/msg/TransitionEvent."
    )
    timestamp: int = read_only("In nanoseconds.")
    stamp: Any = read_only("The same time as `sec` and `nanosec`, as it is called since Lyrical.")
    transition: str = read_only("The label of the transition.")
    start_state: str = read_only("The state that was left.")
    goal_state: str = read_only("The state that was entered.")

    def __init__(self, *, action: Any, msg: Any) -> None:
        self.__action = action
        self.__msg = msg
        self.__stamp = msg.stamp if hasattr(msg, "stamp") else _stamp(int(msg.timestamp))
        self.__timestamp = self.__stamp.sec * _SECOND + self.__stamp.nanosec
        self.__transition = str(msg.transition.label)
        self.__start_state = str(msg.start_state.label)
        self.__goal_state = str(msg.goal_state.label)


def _stamp(ns: int) -> SimpleNamespace:
    return SimpleNamespace(sec=ns // _SECOND, nanosec=ns % _SECOND)


def matches_node_name(node_name: str) -> Callable[[Any], bool]:
    """A matcher for the node with this full name; the leading slash is optional."""
    wanted = node_name if node_name.startswith("/") else f"/{node_name}"
    return lambda action: bool(action.node_name == wanted)


@public("launch_ros.event_handlers.on_state_transition")
class OnStateTransition(EventHandler):
    """Reacts to a transition of a lifecycle node; a criterion of None matches all.

    The node may be a LifecycleNode or, unlike in ROS 2, a ComposableLifecycleNode.
    """

    def __init__(
        self,
        *,
        entities: Any,
        target_lifecycle_node: Any = None,
        transition: object = None,
        start_state: object = None,
        goal_state: object = None,
        matcher: Callable[[Event], bool] | None = None,
        **kwargs: Any,
    ) -> None:
        if not getattr(target_lifecycle_node, "is_lifecycle_node", target_lifecycle_node is None):
            is_node = isinstance(target_lifecycle_node, LifecycleNode)
            raise RuntimeError(_NO_LIFECYCLE if is_node else _NO_NODE)
        self.__target = target_lifecycle_node
        self.__wanted = {
            "transition": transition,
            "start_state": start_state,
            "goal_state": goal_state,
        }
        super().__init__(matcher=matcher or self.__is_match, entities=entities, **kwargs)
        if matcher is None:
            self._expects(StateTransition)

    def __is_match(self, event: Event) -> bool:
        if not isinstance(event, StateTransition):
            return False
        if self.__target is not None and event.action is not self.__target:
            return False
        return all(
            wanted is None or getattr(event, attribute) == wanted
            for attribute, wanted in self.__wanted.items()
        )

    @property
    def handler_description(self) -> str:
        return "<actions>"

    @property
    def matcher_description(self) -> str:
        if self.__target is None:
            return "event == StateTransition"
        return (
            f"event == StateTransition and event.action == LifecycleNode({hex(id(self.__target))})"
        )


@public("launch_ros.utilities.lifecycle_event_manager")
class LifecycleEventManager:
    """Emits the transitions of a lifecycle node as events, and handles ChangeState events.

    The node has its full name as `node_name`.
    """

    def __init__(self, lifecycle_node: Any) -> None:
        self.__lifecycle_node = lifecycle_node
        # Requests to a node that is being loaded; None: it is a process, or loaded.
        self.__held: list[Callable[[], None]] | None = None

    @property
    def node_name(self) -> str:
        """The full name of the node."""
        name: str = self.__lifecycle_node.node_name
        return name

    def setup_lifecycle_manager(self, context: LaunchContext) -> None:
        """Watch the node, and register the handler of ChangeState events."""
        context._host.request(WatchLifecycle(node=self.node_name))
        context._host.watch_lifecycle(
            self.node_name, lambda seen: self._on_transition(context, seen)
        )
        handler = EventHandler(
            matcher=lambda event: isinstance(event, ChangeState),
            entities=[OpaqueFunction(function=self._on_change_state)],
        )
        handler._expects(ChangeState)
        context.register_event_handler(handler)

    def _hold(self) -> None:
        """The node is being loaded."""
        self.__held = self.__held or []

    def _release(self, *, is_loaded: bool) -> None:
        """Make the requests that came meanwhile; without the node, drop them."""
        held, self.__held = self.__held or (), None
        for send in held if is_loaded else ():
            send()

    def _on_change_state(self, context: LaunchContext) -> None:
        event = context.locals.event
        if not event.lifecycle_node_matcher(self.__lifecycle_node):
            return
        number = event.transition_id
        label = lifecycle_transitions.TRANSITIONS[number].label
        request = StateRequest(node=self.node_name, transition_id=number, transition=label)

        def answered(answer: StateChanged) -> None:
            if answer.error is not None:
                constant = ChangeState.valid_transitions[number]
                text = (
                    f"Failed to make transition '{constant}' for LifecycleNode '{self.node_name}'"
                )
                context._host.log(_LOGGER, "ERROR", text)

        def send() -> None:
            context._host.later(lambda: context._host.change_state(request, answered))

        if self.__held is None:
            send()
        else:
            self.__held.append(send)

    def _on_transition(self, context: LaunchContext, seen: TransitionSeen) -> None:
        message = SimpleNamespace(
            timestamp=seen.stamp_ns,
            stamp=_stamp(seen.stamp_ns),
            transition=SimpleNamespace(id=0, label=seen.transition),
            start_state=SimpleNamespace(id=0, label=seen.start_state),
            goal_state=SimpleNamespace(id=0, label=seen.goal_state),
        )
        context.emit_event_sync(StateTransition(action=self.__lifecycle_node, msg=message))


@public("launch_ros.actions.lifecycle_node")
@parsed
class LifecycleNode(Node):
    """Starts a lifecycle node, emits its transitions as events, handles ChangeState events.

    With `autostart`, it is configured and activated.
    """

    node_autostart: Any = read_only("True, false, or substitutions.", of="__autostart")

    def __init__(
        self, *, name: Any, namespace: Any, autostart: object = False, **kwargs: Any
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self.__autostart = normalize_typed_substitution(autostart, bool)
        self.__lifecycle_event_manager: LifecycleEventManager | None = None

    @property
    def is_lifecycle_node(self) -> bool:
        return True

    def get_lifecycle_event_manager(self) -> LifecycleEventManager | None:
        """None before the visit."""
        return self.__lifecycle_event_manager

    def execute(self, context: LaunchContext) -> Any:
        """Start and watch the node; RuntimeError if its full name is unknown."""
        self._perform_substitutions(context)
        if self.UNSPECIFIED_NODE_NAME in self.node_name:
            raise RuntimeError("node_name unexpectedly incomplete for lifecycle node")
        self.__lifecycle_event_manager = LifecycleEventManager(self)
        self.__lifecycle_event_manager.setup_lifecycle_manager(context)
        follows = []
        if perform_typed_substitution(context, self.node_autostart, bool):
            follows.append(activation(self.node_name, self))
        return [*(super().execute(context) or ()), *follows] or None


def activation(node_name: str, node: Any) -> LifecycleTransition:
    """The action that configures and activates the node with this full name."""
    action = LifecycleTransition(
        lifecycle_node_names=[node_name], transition_ids=[_CONFIGURE, _ACTIVATE]
    )
    action._origin = getattr(node, "_origin", None)
    return action


@public("launch_ros.actions.lifecycle_transition")
class LifecycleTransition(Action):
    """Takes lifecycle nodes through a sequence of transitions; stops at the first error."""

    def __init__(self, *, lifecycle_node_names: Any, transition_ids: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        if len(transition_ids) == 0:
            raise ValueError("No transition_ids provided.")
        if len(lifecycle_node_names) == 0:
            raise ValueError("No lifecycle_node_names provided.")
        self.__names = [normalize_to_list_of_substitutions(name) for name in lifecycle_node_names]
        self.__transition_ids = [
            normalize_to_list_of_substitutions(str(number) if isinstance(number, int) else number)
            for number in transition_ids
        ]
        self.__handlers: dict[str, list[EventHandler]] = {}

    def execute(self, context: LaunchContext) -> list[Action]:
        """Yield the handlers for each step, then the events for the first one."""
        names = [perform_substitutions(context, name) for name in self.__names]
        numbers = [_number(perform_substitutions(context, n)) for n in self.__transition_ids]
        emits = {name: [_emit(name, number) for number in numbers] for name in names}
        self.__handlers = {name: [] for name in names}
        actions: list[Action] = []
        for step, number in enumerate(numbers):
            for name in names:
                following = emits[name][step + 1 : step + 2]
                handler = self._step_handler(name, number, following)
                handler._expects(StateTransition)
                self.__handlers[name].append(handler)
                actions.append(RegisterEventHandler(event_handler=handler))
        for name in names:
            self._watch_errors(context, name)
        return [*actions, *(emits[name][0] for name in names)]

    def _step_handler(self, name: str, number: int, following: Sequence[Action]) -> EventHandler:
        transition = lifecycle_transitions.TRANSITIONS[number]
        done = OpaqueFunction(function=lambda context: self._unregister(context, name))
        return OnStateTransition(
            matcher=_transition_matcher(name, transition.goal, transition.between),
            entities=list(following) or [done],
            handle_once=True,
        )

    def _watch_errors(self, context: LaunchContext, name: str) -> None:
        reason = "error occurred during transitions"
        unregister = OpaqueFunction(
            function=lambda context: self._unregister(context, name, reason)
        )
        handler = EventHandler(
            matcher=_transition_matcher(name, "errorprocessing"),
            entities=[unregister],
            handle_once=True,
        )
        handler._expects(StateTransition)
        self.__handlers[name].append(handler)
        context.register_event_handler(handler)

    def _unregister(self, context: LaunchContext, name: str, reason: str | None = None) -> None:
        if reason is not None:
            text = f"Stopping transitions for {name} because '{reason}'"
            context._host.log("launch_ros.actions.lifecycle_transition", "INFO", text)
        for handler in self.__handlers[name]:
            if handler in context._event_handlers:
                context.unregister_event_handler(handler)


def _number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"expected integer for lifecycle transition, got {text}") from None


def _emit(name: str, number: int) -> EmitEvent:
    matcher = matches_node_name(name)
    return EmitEvent(event=ChangeState(lifecycle_node_matcher=matcher, transition_id=number))


def _transition_matcher(
    name: str, goal_state: str, start_state: str | None = None
) -> Callable[[Event], bool]:
    is_node = matches_node_name(name)

    def matcher(event: Event) -> bool:
        return (
            isinstance(event, StateTransition)
            and is_node(event.action)
            and event.goal_state == goal_state
            and start_state in (None, event.start_state)
        )

    return matcher
