"""Subscribes to topics and takes their messages in bursts.

The middleware stamps each message on arrival, so it is enough to take every few milliseconds all
that have arrived. rclpy's executor would build a wait set for each of thousands of messages a
second.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, name_fault
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.decoding import decoder
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.qos_matching import Mismatch
from launcher.ros.snapshot.ros_graph import Direction, Endpoint
from launcher.ros.topics import qos
from launcher.ros.topics.fitted import Fitted
from launcher.ros.topics.raw import RawMessage, RawTaker, subscribed
from launcher.ros.topics.topic_history import TopicHistory
from launcher.ros.topics.unmatched import Unmatched
from launcher.ros.verb import warn

if TYPE_CHECKING:
    from rclpy.node import Node

    from launcher.ros.discovery.observer import Observer

_PERIOD_S = 0.004
_BURST = 1000
_EXPLAIN_PERIOD_S = 0.5
_FIT_PERIOD_S = 0.05
_DISCOVERY_S = 3.0  # of publishers that only the prefetch has discovered


@dataclass(frozen=True, slots=True, kw_only=True)
class ReceivedMessage:
    """A message (bytes if taken raw) and rclpy's info; times are wall clock nanoseconds.

    `is_history`: it was published before the subscription. `publisher` is a GID.
    """

    topic: str
    message: Any
    info: dict[str, Any]
    is_history: bool = False
    publisher: bytes = b""

    @property
    def received_ns(self) -> int:
        return int(self.info["received_timestamp"])


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicTarget:
    """A topic to subscribe to, its type and the publishers that were there at the start."""

    name: str
    type: str
    publishers: tuple[Endpoint, ...]


def full_topic(name: str) -> str:
    """The name with its slash; VerbError if it is not a valid one."""
    from rclpy.exceptions import InvalidTopicNameException
    from rclpy.validate_full_topic_name import validate_full_topic_name

    full = full_name(name)
    try:
        validate_full_topic_name(full)
    except InvalidTopicNameException as error:
        raise VerbError(name_fault(error)) from None
    except TypeError:  # of pybind11
        raise VerbError(f"not UTF-8: {full!a}") from None
    return full


@dataclass(slots=True, kw_only=True)
class _TopicSubscription:
    """`undiscovered`: gids of publishers that only the prefetch has found so far."""

    target: TopicTarget
    fitted: Fitted
    decode: Callable[[bytes], Any]
    is_fixed: bool
    undiscovered: set[str]
    history: TopicHistory | None = None
    unmatched: Unmatched = field(default_factory=Unmatched)
    since_s: float = field(default_factory=time.monotonic)


class Listener:
    """Subscriptions of an observer, or of another `node`; `samples` yields what they receive."""

    def __init__(
        self,
        observer: Observer,
        *,
        raw: bool,
        taker: RawTaker | None = None,
        node: Node | None = None,
    ) -> None:
        self._observer = observer
        self._node = observer.node if node is None else node
        self._raw = raw
        self._taker = RawTaker() if taker is None else taker
        self._topics: list[_TopicSubscription] = []

    def subscribe(
        self, target: TopicTarget, profile: object = None, depth: int = qos.LISTEN_DEPTH
    ) -> None:
        """Subscribe with this profile, or with what fits the publishers, now and in `fit`.

        Without a profile and publishers there is no subscription until there are some.
        """
        kind = with_library(load_message(target.type))

        def create(fitting: object) -> Any:
            topic.history = _history(fitting)
            return subscribed(self._node, kind, target.name, fitting)

        topic = _TopicSubscription(
            target=target,
            fitted=Fitted(
                self._node,
                self._taker,
                create,
                lambda publishers: qos.listening(publishers, depth)[0],
            ),
            decode=bytes if self._raw else decoder(kind),
            is_fixed=profile is not None,
            undiscovered={one.gid for one in target.publishers},
        )
        if profile is None:
            topic.fitted.fit(target.publishers)
        else:
            topic.fitted.use(profile)
        self._topics.append(topic)

    def fit(self, name: str, publishers: Sequence[Endpoint]) -> None:
        """Subscribe to a topic as it fits these publishers, which are all that there are."""
        self._topic(name).fitted.fit(publishers)

    def profile(self, name: str) -> Any:
        """The profile of the subscription to a topic; None while there is none."""
        return self._topic(name).fitted.profile

    def endpoint(self, name: str, node: str) -> Endpoint:
        """That subscription, as if it were of this node."""
        topic = self._topic(name)
        profile, kind = topic.fitted.profile, topic.target.type
        return qos.endpoint_of(profile, Direction.SUBSCRIPTION, name, kind, node=node)

    def _topic(self, name: str) -> _TopicSubscription:
        return next(topic for topic in self._topics if topic.target.name == name)

    def _fit_all(self) -> None:
        for topic in self._topics:
            infos = self._observer.infos(topic.target.name, Direction.PUBLISHER)
            topic.undiscovered.difference_update(info.gid for info in infos)
            is_young = time.monotonic() - topic.since_s < _DISCOVERY_S
            if not topic.is_fixed and not (topic.undiscovered and is_young):
                topic.fitted.fit([info.endpoint() for info in infos])

    def take(self) -> list[ReceivedMessage]:
        """The messages that are there now, at most 1000 of each subscription."""
        return [
            self._sample(topic, raw, is_history)
            for topic in self._topics
            for raw, is_history in self._taken(topic)
        ]

    def take_raw(self) -> list[tuple[RawMessage, bool]]:
        """The same as they come, and whether each is history: half the time of `take`."""
        return [found for topic in self._topics for found in self._taken(topic)]

    @staticmethod
    def _taken(topic: _TopicSubscription) -> list[tuple[RawMessage, bool]]:
        found = [raw for raw, _ in topic.fitted.take(_BURST)]
        if topic.history is None:
            return [(raw, False) for raw in found]
        has = topic.history.has
        return [(raw, has(raw.publisher, raw.source_ns, raw.received_ns)) for raw in found]

    @staticmethod
    def _sample(topic: _TopicSubscription, raw: RawMessage, is_history: bool) -> ReceivedMessage:
        return ReceivedMessage(
            topic=topic.target.name,
            message=topic.decode(raw.data),
            info={
                "source_timestamp": raw.source_ns,
                "received_timestamp": raw.received_ns,
                "publication_sequence_number": raw.sequence,
                "reception_sequence_number": None,
            },
            is_history=is_history,
            publisher=raw.publisher,
        )

    def close(self) -> None:
        for topic in self._topics:
            topic.fitted.close()
        self._topics.clear()

    def samples(self, tick: Callable[[], bool]) -> Iterator[ReceivedMessage]:
        """All messages until `tick`, which is called after each burst, returns False.

        Warns, once for each reason, of publishers from which nothing will come.
        """
        next_fit = next_check = time.monotonic()
        while True:
            samples = self.take()
            yield from samples
            if not tick():
                return
            if time.monotonic() >= next_fit:
                self._fit_all()
                next_fit = time.monotonic() + _FIT_PERIOD_S
            if time.monotonic() >= next_check:
                self._warn_of_unmatched()
                next_check = time.monotonic() + _EXPLAIN_PERIOD_S
            if not samples:
                time.sleep(_PERIOD_S)

    def _warn_of_unmatched(self) -> None:
        for topic in self._topics:
            if topic.fitted.profile is None:
                continue
            name = topic.target.name
            own = self.endpoint(name, "this command")
            publishers = [e for e in self._observer.endpoints(name) if e.is_publisher]
            text_of = functools.partial(_nothing_received, name, len(publishers))
            if text := topic.unmatched.news([*publishers, own], text_of):
                warn(text)


def _history(profile: Any) -> TopicHistory | None:
    from rclpy.qos import DurabilityPolicy

    is_kept = profile.durability != DurabilityPolicy.VOLATILE
    return TopicHistory(time.time_ns()) if is_kept else None


def _nothing_received(topic: str, publishers: int, found: list[Mismatch], reasons: str) -> str:
    silent = [publisher for one in found for publisher in one.publishers]
    names = ", ".join(publisher.shown_node for publisher in silent)
    source = f" from {names}" if len(silent) < publishers else ""
    return f"nothing will be received on {topic}{source}:\n{reasons}"
