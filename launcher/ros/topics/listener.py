"""Subscribes to topics, now or as soon as they are published, and takes their messages in bursts.

The middleware stamps each message on arrival, so it is enough to take every few milliseconds all
that have arrived. rclpy's executor would build a wait set for each of thousands of messages a
second.
"""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from launcher.base.command_line import Parsed
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean, name_fault
from launcher.posix.domains import why_empty
from launcher.ros.discovery.completeness import settle
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.graph import Direction, Endpoint, GraphSnapshot
from launcher.ros.snapshot.qos_matching import Mismatch
from launcher.ros.topics import qos
from launcher.ros.topics.fitted import Fitted
from launcher.ros.topics.history import History
from launcher.ros.topics.raw import RawMessage, RawTaker
from launcher.ros.topics.unmatched import Unmatched
from launcher.ros.verb import spin_time_s, warn

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

_PERIOD_S = 0.004
_BURST = 1000
_STEADY_S = 0.06  # endpoints of one participant arrive together
_EXPLAIN_PERIOD_S = 0.5
_FIT_PERIOD_S = 0.05
_DISCOVERY_S = 3.0  # of publishers that only the prefetch has discovered
_INTRODUCTION_S = 0.3
_AWAIT_PERIOD_S = 0.1  # after it, all endpoints of a participant are known


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """A message (bytes if taken raw) and rclpy's info; times are wall clock nanoseconds.

    `is_history`: it was published before the subscription.
    """

    topic: str
    message: Any
    info: dict[str, Any]
    is_history: bool = False

    @property
    def received_ns(self) -> int:
        return int(self.info["received_timestamp"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
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


def are_published(names: Iterable[str]) -> Callable[[GraphSnapshot], bool]:
    """Checks whether a graph has publishers of all these topics."""
    full = list(map(full_name, names))
    return lambda graph: all(graph.on(name, Direction.PUBLISHER) for name in full)


def _target(
    graph: GraphSnapshot | Observer, full: str, type_name: str | None = None
) -> Target | None:
    """The topic as the graph has it; None if its type is unknown.

    With a type the topic need not exist yet. VerbError if there are several types.
    """
    types = graph.topic_types().get(full, [])
    if type_name is None and len(types) > 1:
        raise VerbError(
            f"Cannot echo topic '{full}', as it contains more than one type: [{', '.join(types)}]",
            hint="name one of them after the topic",
        )
    if type_name is None and not types:
        return None
    publishers = tuple(e for e in graph.endpoints(full) if e.is_publisher)
    return Target(name=full, type=type_name or types[0], publishers=publishers)


def _first_target(
    observer: Observer, name: str, type_name: str | None, options: Parsed
) -> Target | None:
    """The topic as soon as its publishers are known; None if it has none and no type."""
    full = full_topic(name)
    if (graph := observer.prefetched_graph()) is None:
        _await_publishers(observer, full, spin_time_s(options))
        return _target(observer, full, type_name)
    if target := _target(graph, full, type_name):
        _await_introduction(observer, target)
    return target


def _await_introduction(observer: Observer, target: Target) -> None:
    """Return when rclpy knows the publishers of a target that was prefetched, or soon.

    A publisher may publish at once when it discovers our subscription, and we have to know it then.
    """
    deadline = time.monotonic() + _INTRODUCTION_S
    while time.monotonic() < deadline:
        if len(observer.infos(target.name, Direction.PUBLISHER)) >= len(target.publishers):
            return
        time.sleep(_PERIOD_S)


def _await_publishers(observer: Observer, full: str, spin_time_s: float) -> None:
    """Return when the topic has had the same publishers for a moment, or the graph is settled."""
    last, changed = 0, time.monotonic()

    def steady() -> bool:
        nonlocal last, changed
        infos = observer.infos(full, Direction.PUBLISHER)
        if len(infos) != last or not all(info.node for info in infos):
            last, changed = len(infos), time.monotonic()
        return bool(infos) and time.monotonic() - changed > _STEADY_S

    settle(observer, spin_time_s, enough=steady)


@dataclass(slots=True, kw_only=True)
class _Topic:
    """`undiscovered`: gids of publishers that only the prefetch knows yet."""

    target: Target
    fitted: Fitted
    decode: Callable[[bytes], Any]
    is_fixed: bool
    undiscovered: set[str]
    history: History | None = None
    unmatched: Unmatched = field(default_factory=Unmatched)
    since_s: float = field(default_factory=time.monotonic)


class Listener:
    """Subscriptions of an observer; `samples` yields what they receive."""

    def __init__(self, observer: Observer, *, raw: bool, taker: RawTaker | None = None) -> None:
        self._observer = observer
        self._raw = raw
        self._taker = RawTaker() if taker is None else taker
        self._topics: list[_Topic] = []

    def subscribe(self, target: Target, profile: Any = None, depth: int = qos.LISTEN_DEPTH) -> None:
        """Subscribe with this profile, or with what fits the publishers, now and in `fit`.

        Without a profile and publishers there is no subscription until there are some.
        """
        from rclpy.serialization import deserialize_message

        kind = with_library(load_message(target.type))

        def create(fitting: Any) -> Any:
            topic.history = _history(fitting)
            return self._observer.node.create_subscription(
                kind, target.name, _ignore, fitting, raw=True
            )

        topic = _Topic(
            target=target,
            fitted=Fitted(
                self._observer.node,
                self._taker,
                create,
                lambda publishers: qos.listening(publishers, depth)[0],
            ),
            decode=bytes if self._raw else lambda data: deserialize_message(data, kind),
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

    def _topic(self, name: str) -> _Topic:
        return next(topic for topic in self._topics if topic.target.name == name)

    def _fit_all(self) -> None:
        for topic in self._topics:
            infos = self._observer.infos(topic.target.name, Direction.PUBLISHER)
            topic.undiscovered.difference_update(info.gid for info in infos)
            is_young = time.monotonic() - topic.since_s < _DISCOVERY_S
            if not topic.is_fixed and not (topic.undiscovered and is_young):
                topic.fitted.fit([info.endpoint() for info in infos])

    def take(self) -> list[Sample]:
        """The messages that are there now, at most 1000 of each subscription."""
        return [
            self._sample(topic, raw)
            for topic in self._topics
            for raw, _ in topic.fitted.take(_BURST)
        ]

    @staticmethod
    def _sample(topic: _Topic, raw: RawMessage) -> Sample:
        return Sample(
            topic=topic.target.name,
            message=topic.decode(raw.data),
            info={
                "source_timestamp": raw.source_ns,
                "received_timestamp": raw.received_ns,
                "publication_sequence_number": raw.sequence,
                "reception_sequence_number": None,
            },
            is_history=_is_history(topic, raw),
        )

    def close(self) -> None:
        for topic in self._topics:
            topic.fitted.close()
        self._topics.clear()

    def samples(self, tick: Callable[[], bool]) -> Iterator[Sample]:
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


def _is_history(topic: _Topic, raw: RawMessage) -> bool:
    history = topic.history
    return history is not None and history.has(raw.publisher, raw.source_ns, raw.received_ns)


def _history(profile: Any) -> History | None:
    from rclpy.qos import DurabilityPolicy

    is_kept = profile.durability != DurabilityPolicy.VOLATILE
    return History(time.time_ns()) if is_kept else None


def _nothing_received(topic: str, publishers: int, found: list[Mismatch], reasons: str) -> str:
    silent = [publisher for one in found for publisher in one.publishers]
    names = ", ".join(publisher.shown_node for publisher in silent)
    source = f" from {names}" if len(silent) < publishers else ""
    return f"nothing will be received on {topic}{source}:\n{reasons}"


def _ignore(message: Any) -> None:
    """A callback that no executor ever calls: messages are taken by `Listener.take`."""


def subscribe_now(observer: Observer, listener: Listener, name: str, options: Parsed) -> None:
    """Subscribe; VerbError with the text of ros2cli if the type is unknown."""
    target = _first_target(observer, name, options.message_type, options)
    if target is None:
        print(_unpublished(name), flush=True)
        raise VerbError(
            "Could not determine the type for the passed topic", hint=_hint(observer, name)
        )
    _subscribe(listener, target, options)


class AwaitedTopics:
    """Subscribes to topics now, and to unpublished ones as soon as they are published.

    `found` is called for each.
    """

    def __init__(
        self,
        observer: Observer,
        listener: Listener,
        names: Sequence[str],
        options: Parsed,
        found: Callable[[Target], None],
    ) -> None:
        self._observer = observer
        self._listener = listener
        self._options = options
        self._found = found
        self._missing: dict[str, Target | None] = {}
        for name in names:
            if target := _first_target(observer, name, None, options):
                self._take(target)
            else:
                self._miss(name)
        self._next_check = time.monotonic() + _AWAIT_PERIOD_S

    def _miss(self, name: str) -> None:
        self._missing[name] = None
        print(_unpublished(name), flush=True)
        if hint := _hint(self._observer, name):
            warn(f"hint: {hint}")

    def _take(self, target: Target) -> None:
        _subscribe(self._listener, target, self._options)
        self._found(target)

    def poll(self) -> None:
        """Subscribe to missing topics that are published now; checks at most ten times a second."""
        if not self._missing or time.monotonic() < self._next_check:
            return
        for name, before in list(self._missing.items()):
            target = self._missing[name] = _target(self._observer, full_topic(name))
            if target is not None and target == before:
                del self._missing[name]
                self._take(target)
        self._next_check = time.monotonic() + _AWAIT_PERIOD_S


def _hint(observer: Observer, name: str) -> str | None:
    """What to do about an unpublished topic."""
    graph = observer.prefetched_graph() or observer.graph_snapshot()
    return did_you_mean(name, graph.topic_types()) if graph.nodes else why_empty(observer.domain_id)


def _unpublished(name: str) -> str:
    return f"WARNING: topic [{name}] does not appear to be published yet"


def _subscribe(listener: Listener, target: Target, options: Parsed) -> None:
    profile, notes = qos.listening(target.publishers)
    if qos.asked(options):
        listener.subscribe(target, qos.from_options(options, profile))
        return
    for note in notes:
        print(note)
    sys.stdout.flush()
    listener.subscribe(target)
