"""Subscriptions to topics: they exist while clients want them, and fit the publishers."""

from __future__ import annotations

import contextlib
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

from rclpy.qos import DurabilityPolicy

from launcher.ros.discovery.observer import Observer
from launcher.ros.errors import VerbError
from launcher.ros.foxglove.receiver import Deliver, Receiver
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.topics import qos

Client = Hashable


@dataclass(slots=True)
class _Feed:
    """A subscription and who gets its messages."""

    subscription: Any = None
    sinks: tuple[Deliver, ...] = ()

    def deliver(self, time_ns: int, payload: bytes) -> None:
        for sink in self.sinks:
            sink(time_ns, payload)


@dataclass(slots=True)
class _Topic:
    kind: Any
    sinks: dict[Client, Deliver] = field(default_factory=dict)
    profile: Any = None
    feeds: dict[Client | None, _Feed] = field(default_factory=dict)


class Feeds:
    """All methods belong to one thread, that of everything that changes endpoints.

    Clients share a subscription, except of publishers that keep messages for those who come late
    (TRANSIENT_LOCAL): these send them once to each subscription, and so to each client.
    """

    def __init__(self, observer: Observer, receiver: Receiver) -> None:
        self._observer = observer
        self._receiver = receiver
        self._topics: dict[str, _Topic] = {}

    @property
    def topics(self) -> set[str]:
        return set(self._topics)

    def subscribe(self, topic: str, type_name: str, client: Client, sink: Deliver) -> None:
        """VerbError if messages of this type cannot be received here, at least not now."""
        if topic not in self._topics:
            self._topics[topic] = _Topic(with_library(load_message(type_name)))
        self._topics[topic].sinks[client] = sink
        self._fit(topic)

    def unsubscribe(self, topic: str, client: Client) -> None:
        if topic in self._topics:
            self._topics[topic].sinks.pop(client, None)
            self._fit(topic)

    def fit_all(self) -> None:
        """Fit the subscriptions again, after publishers have come or gone."""
        for topic in list(self._topics):
            with contextlib.suppress(VerbError):  # tried again the next time
                self._fit(topic)

    def close(self) -> None:
        for topic in self._topics.values():
            topic.sinks.clear()
        self.fit_all()

    def _fit(self, name: str) -> None:
        topic = self._topics[name]
        endpoints = self._observer.endpoints(name) if topic.sinks else []
        profile, _ = qos.listening(e for e in endpoints if e.is_publisher)
        clients: set[Client | None] = set(topic.sinks)
        is_shared = profile.durability != DurabilityPolicy.TRANSIENT_LOCAL
        wanted = {None} if is_shared and clients else clients
        is_changed = topic.profile != profile
        for client in [key for key in topic.feeds if is_changed or key not in wanted]:
            self._end(topic.feeds.pop(client))
        topic.profile = profile
        for client in wanted:
            feed = topic.feeds.get(client)
            sinks = topic.sinks.values() if client is None else (topic.sinks[client],)
            if feed is not None:
                feed.sinks = tuple(sinks)
            else:
                topic.feeds[client] = self._begin(name, topic, tuple(sinks))
        if not topic.sinks:
            del self._topics[name]

    def _begin(self, name: str, topic: _Topic, sinks: tuple[Deliver, ...]) -> _Feed:
        feed = _Feed(sinks=sinks)
        try:
            feed.subscription = self._observer.node.create_subscription(
                topic.kind, name, _ignore, topic.profile, raw=True
            )
        except RuntimeError as error:  # of rclpy: this process has the topic with another type
            raise VerbError(f"cannot subscribe: {reason(error)}") from None
        self._receiver.add(feed.subscription, feed.deliver)
        return feed

    def _end(self, feed: _Feed) -> None:
        self._receiver.remove(feed.subscription)
        self._observer.node.destroy_subscription(feed.subscription)


def reason(error: Exception) -> str:
    """The text of an error of rclpy in one line, without a place in its sources."""
    return str(error).partition("\n")[0].partition(", at /")[0] or type(error).__name__


def _ignore(message: Any) -> None:
    """A callback that no executor ever calls: the receiver takes the messages."""
