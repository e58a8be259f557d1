"""Listener: takes the messages of topics in bursts, with the times at which they arrived.

The middleware stamps each message on arrival, so they need not be taken one by one as they come:
a look every few milliseconds takes all that are there. That is what keeps up with thousands of
messages a second; rclpy's executor would build a wait set for each of them.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from launcher.ros.discovery.completeness import settle
from launcher.ros.discovery.domains import why_empty
from launcher.ros.errors import VerbError, did_you_mean
from launcher.ros.messages.interfaces import full_type, load_message
from launcher.ros.snapshot.graph import UNKNOWN_NODE, Direction, Endpoint, GraphSnapshot
from launcher.ros.snapshot.qos_matching import explain, mismatches
from launcher.ros.topics import qos
from launcher.ros.verb import spin_time_s, warn

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer


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


def are_published(names: Iterable[str]) -> Callable[[GraphSnapshot], bool]:
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


def target_in(look: GraphSnapshot, name: str, type_name: str | None) -> Target | None:
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
        return qos.endpoint_of(
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
    profile, notes = qos.listening(target.publishers)
    if qos.asked(options):
        return qos.from_options(options, profile), []
    return profile, notes


_AWAIT_PERIOD_S = 0.1  # endpoints of one participant arrive together, so the next look has them all


def subscribe_now(observer: Observer, listener: Listener, name: str, options: Namespace) -> None:
    """Subscribe; VerbError as ros2cli words it if the type cannot be told."""
    target = _first_target(observer, name, options.message_type, options)
    if target is None:
        print(_unpublished(name), flush=True)
        raise VerbError(
            "Could not determine the type for the passed topic", hint=_hint(observer, name)
        )
    _subscribe(listener, target, options)


class AwaitedTopics:
    """Subscribes to topics now, and to those that nobody has yet as soon as somebody does.

    `found` is told of each.
    """

    def __init__(
        self,
        observer: Observer,
        listener: Listener,
        names: Sequence[str],
        options: Namespace,
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
        self._next_look = time.monotonic() + _AWAIT_PERIOD_S

    def _miss(self, name: str) -> None:
        self._missing[name] = None
        print(_unpublished(name), flush=True)
        if hint := _hint(self._observer, name):
            warn(f"hint: {hint}")

    def _take(self, target: Target) -> None:
        _subscribe(self._listener, target, self._options)
        self._found(target)

    def look(self) -> None:
        """Look for those that are missing, ten times a second; call it as often as you like."""
        if not self._missing or time.monotonic() < self._next_look:
            return
        for name, before in list(self._missing.items()):
            target = self._missing[name] = target_now(self._observer, name)
            if target is not None and target == before:
                del self._missing[name]
                self._take(target)
        self._next_look = time.monotonic() + _AWAIT_PERIOD_S


def _first_target(
    observer: Observer, name: str, type_name: str | None, options: Namespace
) -> Target | None:
    """The topic as it is at the start."""
    if (look := observer.seen_ahead()) is not None:
        target = target_in(look, name, type_name)
        if target is not None:
            await_introduction(observer, target)
        return target
    return find_target(observer, name, type_name, spin_time_s(options))


def _hint(observer: Observer, name: str) -> str | None:
    """For a name that nobody has."""
    look = observer.seen_ahead() or observer.graph_snapshot()
    return did_you_mean(name, look.topic_types()) if look.nodes else why_empty(observer.domain_id)


def _unpublished(name: str) -> str:
    return f"WARNING: topic [{name}] does not appear to be published yet"


def _subscribe(listener: Listener, target: Target, options: Namespace) -> None:
    profile, notes = fitted_profile(target, options)
    for note in notes:
        print(note)
    sys.stdout.flush()
    listener.subscribe(target, profile)
