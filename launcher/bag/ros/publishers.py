"""Publishes what a bag has: messages, requests of services, and `/clock`."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from launcher.bag import bag_actions
from launcher.bag.agreement import difference
from launcher.bag.bag_model import CDR, Message, Qos, Topic
from launcher.bag.bag_services import EVENTS
from launcher.bag.ros import bag_qos
from launcher.bag.ros.recorded_calls import (
    ActionRequests,
    Requester,
    requester,
    why_nothing_was_sent,
)
from launcher.base.ros_errors import VerbError
from launcher.base.text import count, escape
from launcher.ros.messages.classes import type_name, with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.qos_matching import mismatches
from launcher.ros.snapshot.ros_graph import Direction, GraphSnapshot
from launcher.ros.topics import qos

if TYPE_CHECKING:
    from rclpy.publisher import Publisher

    from launcher.ros.discovery.observer import Observer

_DEPTH = 1000  # of volatile topics: room for bursts that a subscription is slow to take
_PERIOD_S = 0.01
_SLICE_NS = 100_000_000
_UNKNOWN_S = 1.0  # for a service that was not in the graph
_SHARED = ("/rosout", "/parameter_events")  # every node publishes them
_NAMED = 5  # topics in a warning; others are counted


class Publishers:
    """A publisher for each topic that can be played; `notes` gets a sentence for the others.

    `remap` maps names of the bag, also of services and actions, to those that are published. With
    `requests`, recorded calls of services are sent as calls; with `goals`, those of actions. Both
    say whose events are used.
    """

    def __init__(
        self,
        observer: Observer,
        overrides: Mapping[str, Qos],
        remap: Mapping[str, str],
        notes: Callable[[str], None],
        *,
        requests: str | None = None,
        goals: str | None = None,
    ) -> None:
        self._observer = observer
        self._overrides = overrides
        self._remap = remap
        self._notes = notes
        self._requests = requests
        self._goals = goals
        self._added: dict[str, Topic] = {}
        self._noted: set[str] = set()
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Requester] = {}  # topic -> where its requests are sent
        self._actions: dict[str, ActionRequests] = {}
        self._clock: Any = None

    def add(self, topic: Topic) -> bool:
        """Whether the topic can be played, also together with one of its name that was added."""
        name = bag_actions.renamed(topic, self._remap)
        known = self._added.get(topic.name)
        if self._comes_from_the_server(topic):
            return False
        try:
            if topic.serialization != CDR:
                raise VerbError(f"its messages are in '{topic.serialization}', and ROS 2 has CDR")
            if not topic.type:
                raise VerbError("the bag does not have its type")
            if known is None:
                self._create(topic, name)
                self._added[topic.name] = topic
            elif topic.type != known.type:
                raise VerbError(f"it is {topic.type} in this bag, and {known.type} in another one")
            elif difference(known, topic):
                raise VerbError(f"{topic.type} is not defined as in another bag")
        except VerbError as error:
            self._refuse(topic.name, error)
            return False
        return True

    def _comes_from_the_server(self, topic: Topic) -> bool:
        """Feedback and status of an action whose goals are sent to a server."""
        if self._goals is None or bag_actions.action_of(topic.name, topic.type) is None:
            return False
        return bag_actions.part_of(topic) in bag_actions.TOPICS

    def _create(self, topic: Topic, name: str) -> None:
        """VerbError where ROS has no such name or type."""
        from rclpy.exceptions import NameValidationException

        try:
            action = bag_actions.action_of(topic.name, topic.type)
            service = name.removesuffix(EVENTS)
            if action is not None and self._goals is not None:
                self._add_action(topic, action, service, self._goals)
            elif action is None and self._requests is not None and service != name:
                kind = topic.type.removesuffix("_Event")
                node = self._observer.node
                self._clients[topic.name] = requester(node, service, kind, self._requests)
            else:
                self._publishers[topic.name] = self._observer.node.create_publisher(
                    with_library(load_message(topic.type)), name, self._profile(topic)
                )
        except VerbError as error:
            raise VerbError(f"{topic.type}: {error.message}", hint=error.hint) from None
        except NameValidationException as error:
            reason = str(error).partition("\n")[0].partition(": ")[2].rstrip(":")
            raise VerbError(
                f"'{name}' is no name in ROS: {reason}",
                hint=f"--remap {topic.name}:=NEW plays it with another name",
            ) from None

    def _refuse(self, what: str, error: VerbError) -> None:
        """Say once why something is not played."""
        note = f"{what} is not played: {error.message}"
        note = escape(f"{note}\nhint: {error.hint}" if error.hint else note)
        if note not in self._noted:
            self._noted.add(note)
            self._notes(note)

    def _add_action(self, topic: Topic, action: str, service: str, source: str) -> None:
        if action not in self._actions:
            self._actions[action] = ActionRequests(self._observer.node, source)
        kind = bag_actions.type_of(topic)
        self._clients[topic.name] = self._actions[action].client(
            service, bag_actions.part_of(topic), kind
        )

    def _profile(self, topic: Topic) -> Any:
        from rclpy.qos import DurabilityPolicy

        try:
            profile = bag_qos.to_play(topic.qos)
        except ValueError as error:  # a word that this version of ROS does not know
            self._notes(f"{topic.name} is played with the default QoS: {error}")
            profile = bag_qos.to_play(())
        if profile.durability == DurabilityPolicy.VOLATILE:
            profile.depth = max(profile.depth, _DEPTH)
        override = self._overrides.get(topic.name)
        return profile if override is None else bag_qos.changed(profile, override)

    def add_clock(self) -> None:
        from rosgraph_msgs.msg import Clock

        self._clock = self._observer.node.create_publisher(Clock, "/clock", 10)

    def publish(self, message: Message) -> bool:
        """Whether it was published; of an event, the request may be sent instead."""
        if (client := self._clients.get(message.topic)) is None:
            self._publishers[message.topic].publish(message.data)
            return True
        try:
            client.send(message.data)
        except (RuntimeError, VerbError) as error:  # RMWError
            self._refuse(f"an event of {message.topic}", VerbError(str(error)))
        return False

    @property
    def sent(self) -> int | None:
        """How many requests were sent; None if none are to be."""
        if self._requests is None and self._goals is None:
            return None
        return sum(one.sent for one in self._clients.values())

    def why_nothing_was_sent(self) -> str:
        return why_nothing_was_sent(self._clients.values())

    def poll(self) -> None:
        """Send what had to wait for an answer."""
        for action in self._actions.values():
            action.poll()

    def publish_clock(self, bag_ns: int) -> None:
        from builtin_interfaces.msg import Time
        from rosgraph_msgs.msg import Clock

        seconds, nanoseconds = divmod(bag_ns, 10**9)
        self._clock.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))

    def warn_of_others(self, graph: GraphSnapshot) -> None:
        """Say once which of the topics other nodes of the graph publish as well."""
        found: dict[str, list[str]] = {}
        for publisher in self._all():
            topic = publisher.topic_name
            others = {one.node or "a nameless node" for one in graph.on(topic, Direction.PUBLISHER)}
            if others and topic not in _SHARED:
                found[topic] = sorted(others)
        if not found:
            return
        texts = [f"{topic} ({', '.join(nodes)})" for topic, nodes in found.items()]
        more = [f"{count(len(texts) - _NAMED, 'other topic')}"] if len(texts) > _NAMED else []
        names = ", ".join([*texts[:_NAMED], *more])
        text = f"warning: other nodes publish, too: {names}; subscriptions get the messages of both"
        self._notes(escape(f"{text}\nhint: {self._way_out(found)}"))

    def _way_out(self, published: Mapping[str, object]) -> str:
        """The options with which the first of these topics is not published twice."""
        for name, publisher in self._publishers.items():
            if publisher.topic_name in published:
                renamed = f"--remap {name}:=/bag{publisher.topic_name} plays it with another name"
                return f"{renamed}, --exclude-topics {name} leaves it out"
        return "without --clock, only the other one is there"

    def wait_for_others(self, graph: GraphSnapshot | None, limit_s: float) -> None:
        """Return when the subscriptions and services of the graph are connected."""
        if graph is None:
            return
        subscriptions = [(one, self._matching(graph, one)) for one in self._all()]
        end = time.monotonic() + limit_s
        for publisher, expected in subscriptions:
            while publisher.get_subscription_count() < expected and time.monotonic() < end:
                time.sleep(_PERIOD_S)
        for client in self._clients.values():
            if not graph.servers(client.service):
                end = min(end, time.monotonic() + _UNKNOWN_S)
            while not client.is_ready() and time.monotonic() < end:
                time.sleep(_PERIOD_S)
            if not client.is_ready():
                self._notes(f"the service {client.service} is not there")

    def _all(self) -> list[Any]:
        """The publishers of topics, and that of `/clock`."""
        clock = [] if self._clock is None else [self._clock]
        return [*self._publishers.values(), *clock]

    @staticmethod
    def _matching(graph: GraphSnapshot, publisher: Publisher) -> int:
        own = qos.endpoint_of(
            publisher.qos_profile,
            Direction.PUBLISHER,
            publisher.topic_name,
            type_name(publisher.msg_type),
            node="this command",
        )
        others = graph.on(publisher.topic_name, Direction.SUBSCRIPTION)
        return sum(not mismatches([own, other.endpoint()]) for other in others)

    def wait_for_all_acked(self, limit_s: float) -> bool:
        """Whether all RELIABLE subscriptions and services have everything within this time."""
        from rclpy.duration import Duration

        end = time.monotonic() + limit_s
        for publisher in self._all():
            while not publisher.wait_for_all_acked(Duration(nanoseconds=_SLICE_NS)):
                if time.monotonic() >= end:
                    return False
        for client in self._clients.values():
            while client.is_ready() and client.awaits_answers():
                if time.monotonic() >= end:
                    return False
                time.sleep(_PERIOD_S)
                self.poll()
        return True
