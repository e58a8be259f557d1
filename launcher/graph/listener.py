"""Listener: takes the messages of topics in bursts, with the times at which they arrived.

The middleware stamps each message on arrival, so they need not be taken one by one as they come:
a look every few milliseconds takes all that are there. That is what keeps up with thousands of
messages a second; rclpy's executor would build a wait set for each of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from launcher.graph import profiles
from launcher.graph.errors import VerbError
from launcher.graph.interfaces import full_type, load_message
from launcher.graph.look import UNKNOWN_NODE, Look
from launcher.graph.matching import explain, mismatches
from launcher.graph.settle import settle
from launcher.graph.snapshot import Direction, Endpoint

if TYPE_CHECKING:
    from launcher.graph.observer import Observer

_LOOK_S = 0.004
_BURST = 1000
_STEADY_S = 0.06  # endpoints of one participant arrive together
_GRAPH_LOOK_S = 0.5
_INTRODUCTION_S = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """A message (bytes if taken raw) and rclpy's info: times are wall clock nanoseconds."""

    topic: str
    message: Any
    info: dict[str, Any]

    @property
    def received_ns(self) -> int:
        """When the middleware got it."""
        return int(self.info["received_timestamp"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A topic that is listened to, its type and the publishers that were there at the start."""

    name: str
    type: str
    publishers: tuple[Endpoint, ...]


def full_topic(name: str) -> str:
    """The full name; VerbError if it cannot be one."""
    from rclpy.exceptions import InvalidTopicNameException
    from rclpy.validate_full_topic_name import validate_full_topic_name

    full = name if name.startswith("/") else f"/{name}"
    try:
        validate_full_topic_name(full)
    except InvalidTopicNameException as error:
        raise VerbError(str(error).splitlines()[0]) from None
    return full


def are_published(names: Iterable[str]) -> Callable[[Look], bool]:
    """Whether a look has publishers of all these topics."""
    full = ["/" + name.removeprefix("/") for name in names]
    return lambda look: all(look.on(name, Direction.PUBLISHER) for name in full)


def find_target(
    observer: Observer, name: str, type_name: str | None, spin_time_s: float
) -> Target | None:
    """The topic as soon as its publishers are known to rclpy; otherwise as `target_in`."""
    _await_publishers(observer, full_topic(name), spin_time_s)
    return target_now(observer, name, type_name)


def target_now(observer: Observer, name: str, type_name: str | None = None) -> Target | None:
    """The topic as rclpy knows it at this moment; otherwise as `target_in`."""
    full = full_topic(name)
    types = observer.topic_types().get(full, [])
    return _target(full, type_name, types, observer.endpoints(full))


def target_in(look: Look, name: str, type_name: str | None) -> Target | None:
    """The topic; None if its type cannot be told.

    With a type the topic need not exist yet. VerbError if the name is none or the types differ.
    """
    full = full_topic(name)
    return _target(full, type_name, look.topic_types().get(full, []), look.endpoints(full))


def await_introduction(observer: Observer, target: Target) -> None:
    """Return when rclpy knows the publishers of a target that a scout has seen, or soon.

    Somebody may publish at once when he hears of our subscription, and then we have to know him.
    """
    deadline = time.monotonic() + _INTRODUCTION_S
    while time.monotonic() < deadline:
        if len(observer.infos(target.name, Direction.PUBLISHER)) >= len(target.publishers):
            return
        time.sleep(_LOOK_S)


def _target(
    full: str, type_name: str | None, types: list[str], endpoints: list[Endpoint]
) -> Target | None:
    if type_name is None and len(types) > 1:
        raise VerbError(
            f"Cannot echo topic '{full}', as it contains more than one type: [{', '.join(types)}]",
            hint="name one of them after the topic",
        )
    if type_name is None and not types:
        return None
    publishers = tuple(e for e in endpoints if e.is_publisher)
    return Target(name=full, type=type_name or types[0], publishers=publishers)


def _await_publishers(observer: Observer, full: str, spin_time_s: float) -> None:
    """Return when the topic has had the same publishers for a moment, or the graph is settled."""
    last, changed = 0, time.monotonic()

    def steady() -> bool:
        nonlocal last, changed
        infos = observer.infos(full, Direction.PUBLISHER)
        if len(infos) != last or any(i.node_name == UNKNOWN_NODE for i in infos):
            last, changed = len(infos), time.monotonic()
        return bool(infos) and time.monotonic() - changed > _STEADY_S

    settle(observer, spin_time_s, enough=steady)


class Listener:
    """Subscribes to topics; `samples` yields what comes."""

    def __init__(self, observer: Observer, *, raw: bool) -> None:
        self._observer = observer
        self._raw = raw
        self._subscriptions: list[tuple[Target, Any]] = []
        self._told: set[str] = set()
        self.heard: set[str] = set()

    def subscribe(self, target: Target, profile: Any) -> None:
        """Listen to one more topic."""
        subscription = self._observer.node.create_subscription(
            load_message(target.type), target.name, _ignore, profile, raw=self._raw
        )
        self._subscriptions.append((target, subscription))

    def take(self) -> list[Sample]:
        """All messages that are there now; no end of them from one topic holds up the others."""
        found: list[Sample] = []
        for target, subscription in self._subscriptions:
            take, kind = subscription.handle.take_message, subscription.msg_type
            with subscription.handle:
                for _ in range(_BURST):
                    if (taken := take(kind, self._raw)) is None:
                        break
                    message, info = taken
                    found.append(Sample(topic=target.name, message=message, info=info))
        self.heard.update(sample.topic for sample in found)
        return found

    def close(self) -> None:
        """Listen to nothing more."""
        subscriptions, self._subscriptions = self._subscriptions, []
        for _, subscription in subscriptions:
            self._observer.node.destroy_subscription(subscription)

    def samples(self, tick: Callable[[], bool], say: Callable[[str], None]) -> Iterator[Sample]:
        """What comes, until `tick` (called after each look) says that it is enough.

        `say` is told once of each reason why a topic stays silent.
        """
        next_look = time.monotonic()
        while True:
            samples = self.take()
            yield from samples
            if not tick():
                return
            if time.monotonic() >= next_look:
                self._explain_silence(say)
                next_look = time.monotonic() + _GRAPH_LOOK_S
            if not samples:
                time.sleep(_LOOK_S)

    def _explain_silence(self, say: Callable[[str], None]) -> None:
        for target, subscription in self._subscriptions:
            if target.name in self.heard:
                continue
            text = self._why_silent(target, subscription)
            if text and text not in self._told:
                self._told.add(text)
                say(text)

    def _why_silent(self, target: Target, subscription: Any) -> str | None:
        publishers = [e for e in self._observer.endpoints(target.name) if e.is_publisher]
        known = [*publishers, self._own_endpoint(target, subscription)]
        if not mismatches(known):
            return None
        return f"nothing will be received on {target.name}:\n{explain(known)}"

    def _own_endpoint(self, target: Target, subscription: Any) -> Endpoint:
        return profiles.endpoint_of(
            subscription.qos_profile,
            topic=target.name,
            type_name=full_type(target.type),
            direction=Direction.SUBSCRIPTION,
            node="this command",
        )


def _ignore(message: Any) -> None:
    """Messages are taken by hand; no executor ever calls this."""


def fitted_profile(target: Target, options: Any) -> tuple[Any, list[str]]:
    """The QoS for a topic: what the options ask for, otherwise what fits its publishers."""
    profile, notes = profiles.listening(target.publishers)
    if profiles.asked(options):
        return profiles.from_options(options, profile), []
    return profile, notes
