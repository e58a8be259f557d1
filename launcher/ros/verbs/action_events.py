"""`action echo`: prints what the topics and services of an action publish."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.discovery.completeness import settled_graph
from launcher.ros.messages.classes import type_name
from launcher.ros.messages.interfaces import load
from launcher.ros.snapshot.ros_graph import Direction, GraphSnapshot
from launcher.ros.topics.listener import Listener, ReceivedMessage
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import GraphAccess, observing, warn
from launcher.ros.verbs.awaited_topics import TopicSubscriber
from launcher.ros.verbs.service_events import EventWriter
from launcher.ros.verbs.streams import ListeningLimit, nothing_came, until_interrupted

# Interface -> its topic below that of the action, and its type after that of the action.
_EVENTS = {
    "GOAL_SERVICE": ("send_goal/_service_event", "{}_SendGoal_Event"),
    "CANCEL_SERVICE": ("cancel_goal/_service_event", "action_msgs/srv/CancelGoal_Event"),
    "RESULT_SERVICE": ("get_result/_service_event", "{}_GetResult_Event"),
}
_TOPICS = {
    "FEEDBACK_TOPIC": ("feedback", "{}_FeedbackMessage"),
    "STATUS_TOPIC": ("status", "action_msgs/msg/GoalStatusArray"),
}
INTERFACES = {**_EVENTS, **_TOPICS}


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionEchoOptions:
    """What `action echo` was asked for; the QoS is for events of services."""

    access: GraphAccess
    action: str
    type: str | None
    interfaces: tuple[str, ...]
    writer: InterfaceWriter
    qos: QosOptions
    timeout_s: float | None


class InterfaceWriter(EventWriter):
    """Writes the interface of an action in front of each message."""

    def pieces(
        self, sample: ReceivedMessage, values: Sequence[tuple[str, object]]
    ) -> Iterator[str]:
        if not self.json:
            yield f"interface: {interface_of(sample.topic)}\n"
        yield from super().pieces(sample, values)

    def _document(
        self, sample: ReceivedMessage, values: Sequence[tuple[str, Any]]
    ) -> dict[str, Any]:
        document = super()._document(sample, values)
        return {"interface": interface_of(sample.topic), **document}


def interface_of(topic: str) -> str:
    """The interface of an action that has this topic."""
    below = topic.rpartition("/_action/")[2]
    return next(name for name, (ending, _) in INTERFACES.items() if ending == below)


def chosen_interfaces(words: str | None) -> tuple[str, ...]:
    """Those of `GOAL_SERVICE|status_topic`, all without words; VerbError with ros2cli's texts."""
    if words is None:
        return tuple(INTERFACES)
    if not words:
        raise VerbError("Input action interface name is empty.")
    chosen = [word.strip() for word in words.split("|")]
    for word in chosen:
        if word.upper() not in INTERFACES:
            hint = did_you_mean(word.upper(), INTERFACES) or f"known: {', '.join(INTERFACES)}"
            raise VerbError(f'"{word}" is incorrect interface name.', hint=hint)
    return tuple(dict.fromkeys(word.upper() for word in chosen))


def echo(options: ActionEchoOptions) -> int:
    """Print messages until Ctrl-C, or the end of `timeout_s`."""
    action, writer, is_silent = full_name(options.action), options.writer, True

    def enough(graph: GraphSnapshot) -> bool:
        return action in graph.action_types()

    with (
        until_interrupted(is_end=options.timeout_s is None),
        observing(options.access, enough, listens=True) as observer,
    ):
        graph = settled_graph(observer, options.access.spin_time_s, enough)
        kind = _type(graph, action, options.type)
        listener = Listener(observer, raw=False)
        for interface in options.interfaces:
            below, type_of = INTERFACES[interface]
            qos = options.qos if interface in _EVENTS else QosOptions()
            subscriber = TopicSubscriber(
                observer, listener, qos, options.access.spin_time_s, json=writer.json
            )
            subscriber.subscribe_now(f"{action}/_action/{below}", type_of.format(kind))
        _note_silent_services(graph, action, options.interfaces)
        limit = ListeningLimit(options.timeout_s)
        for sample in listener.samples(limit.tick):
            is_silent, limit.is_fresh = False, True
            sys.stdout.writelines(writer.pieces(sample, writer.values(sample)))
    if is_silent and options.timeout_s is not None:
        return nothing_came([action], options.timeout_s)
    return ExitCode.OK


def _note_silent_services(graph: GraphSnapshot, action: str, chosen: Sequence[str]) -> None:
    """Say once that no service publishes events, as always with the rclpy of Jazzy."""
    services = [_EVENTS[name][0] for name in chosen if name in _EVENTS]
    topics = [f"{action}/_action/{below}" for below in services]
    if topics and not any(graph.on(topic, Direction.PUBLISHER) for topic in topics):
        warn(
            f"hint: the services of '{action}' publish no events: their introspection is off "
            "(Jazzy has none for actions, so there only feedback and status are printed)"
        )


def _type(graph: GraphSnapshot, action: str, given: str | None) -> str:
    """The full type of the action; VerbError with the text of ros2cli."""
    known = graph.action_types()
    types = known.get(action, []) if given is None else [given]
    if not types:
        hint = did_you_mean(action, known)
        raise VerbError(f"Cannot find type for '{action}'", hint=hint)
    if len(types) > 1:
        raise VerbError(
            f"More than one type associated with action '{action}'",
            hint=f"name one of them after the action: {', '.join(types)}",
        )
    return type_name(load(types[0], "action", f"The action type '{types[0]}' is invalid"))
