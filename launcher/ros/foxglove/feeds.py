"""Subscriptions to topics: they exist while clients need them, and fit the publishers."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rclpy.qos import DurabilityPolicy

from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.observer import Observer
from launcher.ros.foxglove.receiver import Deliver, Receiver
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.ros_graph import Direction
from launcher.ros.topics.fitted import OVERLAP_S, Numbers, fitting, is_equal
from launcher.ros.topics.raw import RawMessage, subscribed

if TYPE_CHECKING:
    from rclpy.subscription import Subscription

Client = Hashable


@dataclass(slots=True)
class _Sink:
    """A client, which gets each message once, whichever subscription has it."""

    deliver: Deliver
    numbers: Numbers = field(default_factory=Numbers)

    def put(self, raw: RawMessage) -> None:
        if self.numbers.missed(raw) is not None:
            self.deliver(self.numbers.available_ns(raw), raw.data)


@dataclass(slots=True)
class _Feed:
    """A subscription and who gets its messages."""

    subscription: Subscription | None = None
    sinks: tuple[_Sink, ...] = ()

    def deliver(self, raw: RawMessage) -> None:
        for sink in self.sinks:
            sink.put(raw)


@dataclass(slots=True)
class _TopicFeed:
    """`profile` is None without a subscription; `before`: those replaced, and until when."""

    kind: object
    sinks: dict[Client, _Sink] = field(default_factory=dict)
    profile: object = None
    feeds: dict[Client | None, _Feed] = field(default_factory=dict)
    before: list[tuple[_Feed, float]] = field(default_factory=list)


class TopicFeeds:
    """All methods belong to one thread, that of everything that changes endpoints.

    Clients share a subscription, except of publishers that keep messages for those who come late
    (TRANSIENT_LOCAL): these send them once to each subscription, and so to each client.
    """

    def __init__(self, observer: Observer, receiver: Receiver) -> None:
        self._observer = observer
        self._receiver = receiver
        self._topics: dict[str, _TopicFeed] = {}

    @property
    def topics(self) -> set[str]:
        return set(self._topics)

    def subscribe(self, topic: str, type_name: str, client: Client, sink: Deliver) -> None:
        """VerbError if messages of this type cannot be received here, at least not now."""
        if topic not in self._topics:
            self._topics[topic] = _TopicFeed(with_library(load_message(type_name)))
        self._topics[topic].sinks[client] = _Sink(sink)
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
        # Clients publish as well.
        infos = self._observer.infos(name, Direction.PUBLISHER, with_own=True)
        publishers = [info.endpoint() for info in infos]
        profile = fitting(topic.profile, publishers) if topic.sinks else None
        is_changed = not is_equal(profile, topic.profile)
        topic.profile = profile
        clients: set[Client | None] = set() if profile is None else set(topic.sinks)
        is_kept = profile is not None and profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        wanted = clients if is_kept or not clients else {None}
        overlap_s = OVERLAP_S if clients else 0.0
        for client in [key for key in topic.feeds if is_changed or key not in wanted]:
            topic.before.append((topic.feeds.pop(client), time.monotonic() + overlap_s))
        for client in wanted:
            sinks = tuple(topic.sinks.values()) if client is None else (topic.sinks[client],)
            if client in topic.feeds:
                topic.feeds[client].sinks = sinks
            else:
                topic.feeds[client] = self._begin(name, topic, sinks)
        self._end_those_before(topic)
        if not topic.sinks:
            del self._topics[name]

    def _end_those_before(self, topic: _TopicFeed) -> None:
        for feed, until_s in list(topic.before):
            feed.sinks = tuple(sink for sink in feed.sinks if sink in topic.sinks.values())
            if time.monotonic() >= until_s or not feed.sinks:
                topic.before.remove((feed, until_s))
                self._receiver.remove(feed.subscription)
                self._observer.node.destroy_subscription(feed.subscription)

    def _begin(self, name: str, topic: _TopicFeed, sinks: tuple[_Sink, ...]) -> _Feed:
        feed = _Feed(sinks=sinks)
        try:
            feed.subscription = subscribed(self._observer.node, topic.kind, name, topic.profile)
        except RuntimeError as error:  # of rclpy: this process has the topic with another type
            raise VerbError(f"cannot subscribe: {reason(error)}") from None
        self._receiver.add(feed.subscription, feed.deliver)
        return feed


def reason(error: Exception) -> str:
    """The text of an error of rclpy in one line, without a place in its sources."""
    return str(error).partition("\n")[0].partition(", at /")[0] or type(error).__name__
