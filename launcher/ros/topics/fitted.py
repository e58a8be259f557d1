"""A subscription whose QoS fits the publishers there are, also those that come later.

Without a publisher there is none that fits. One that matches every publisher is BEST_EFFORT: a
publisher that finds it may send before the subscription has discovered it, and is done.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from launcher.ros.topics import qos

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.qos import QoSProfile
    from rclpy.subscription import Subscription

    from launcher.ros.snapshot.ros_graph import Endpoint
    from launcher.ros.topics.raw import RawMessage, RawTaker

    Fitting = Callable[[Sequence[Endpoint]], QoSProfile]

OVERLAP_S = 1.0  # for publishers to discover the subscription that replaces another
_MAX_WAIT_NS = 10 * 10**9  # for a message that is sent again; more: the clock was set
_NO_NUMBER = 2**64 - 1  # of a middleware that does not count messages


def _strongest(publishers: Sequence[Endpoint]) -> QoSProfile:
    return qos.listening(publishers)[0]


class Numbers:
    """The last message of each publisher, by its gid, that any of several subscriptions had."""

    def __init__(self) -> None:
        self.last: dict[bytes, int] = {}
        self._last_ns = 0

    def missed(self, raw: RawMessage) -> int | None:
        """How many before it have not come; None if it was there before."""
        if raw.sequence == _NO_NUMBER:
            return 0
        last = self.last.get(raw.publisher)
        if last is not None and raw.sequence <= last:
            return None
        self.last[raw.publisher] = raw.sequence
        return 0 if last is None else raw.sequence - last - 1

    def available_ns(self, raw: RawMessage) -> int:
        """When it could be taken, after those before it.

        Fast DDS 3 says when it has arrived, even if it had to wait for one that was sent again.
        """
        is_early = 0 < self._last_ns - raw.received_ns < _MAX_WAIT_NS
        self._last_ns = self._last_ns if is_early else raw.received_ns
        return self._last_ns


class Fitted:
    """The messages of a topic, each once, however often the subscription is replaced.

    `create` makes a subscription with a profile; `fit` chooses the profile, as strong as all
    publishers allow without it. `profile` is None while there is no subscription.
    """

    def __init__(
        self,
        node: Node,
        taker: RawTaker,
        create: Callable[[Any], Any],
        fit: Fitting = _strongest,
    ) -> None:
        self.profile: Any = None
        self.numbers = Numbers()
        self.publishers: frozenset[str] = frozenset()
        self._node = node
        self._taker = taker
        self._create = create
        self._fit = fit
        self._subscription: Subscription | None = None
        self._before: list[tuple[Any, float]] = []  # those that were replaced, and until when

    def fit(self, publishers: Sequence[Endpoint]) -> None:
        """Subscribe as it fits these, which are all that there are."""
        gids = frozenset(one.gid for one in publishers)
        if gids == self.publishers:
            return
        self.publishers = gids
        profile = fitting(self.profile, publishers, self._fit)
        if not is_equal(profile, self.profile):
            self.use(profile)

    def use(self, profile: object) -> None:
        """Subscribe with this profile, or with None no more.

        The subscription before goes on until publishers have discovered this one.
        """
        self._retire(0.0 if profile is None else OVERLAP_S)
        self.profile = profile
        if profile is not None:
            self._subscription = self._create(profile)

    def _retire(self, overlap_s: float) -> None:
        if self._subscription is not None:
            self._before.append((self._subscription, time.monotonic() + overlap_s))
            self._subscription = None

    def take(self, most: int) -> Iterator[tuple[RawMessage, int]]:
        """At most so many of the messages that are there now, of each subscription.

        With each, how many of its publisher were lost before it.
        """
        available_ns = self.numbers.available_ns
        for raw, lost in self._new(most):
            at_ns = available_ns(raw)
            yield (raw if at_ns == raw.received_ns else raw._replace(received_ns=at_ns)), lost

    def _new(self, most: int) -> Iterator[tuple[RawMessage, int]]:
        if self._before:
            yield from self._take_overlapping(most)
        elif self._subscription is not None:
            yield from self._once(self._subscription, most)

    def _take_overlapping(self, most: int) -> Iterator[tuple[RawMessage, int]]:
        # What the others have now was sent before what the newest, just discovered, does not have.
        newest = list(self._raw(self._subscription, most)) if self._subscription else []
        for subscription, until_s in list(self._before):
            yield from self._once(subscription, most)
            if time.monotonic() >= until_s:
                self._before.remove((subscription, until_s))
                self._node.destroy_subscription(subscription)
        for raw in newest:
            if (lost := self.numbers.missed(raw)) is not None:
                yield raw, lost

    def _once(self, subscription: Subscription, most: int) -> Iterator[tuple[RawMessage, int]]:
        missed = self.numbers.missed
        for raw in self._raw(subscription, most):
            if (lost := missed(raw)) is not None:
                yield raw, lost

    def _raw(self, subscription: Subscription, most: int) -> Iterator[RawMessage]:
        handle, take = subscription.handle, self._taker.take
        with handle:
            for _ in range(most):
                if (raw := take(handle)) is None:
                    return
                yield raw

    def close(self) -> None:
        self._retire(0.0)
        for subscription, _ in self._before:
            self._node.destroy_subscription(subscription)
        self._before.clear()
        self.profile = None


def fitting(now: Any, publishers: Sequence[Endpoint], fit: Fitting = _strongest) -> Any:
    """The profile for these publishers in place of the one now; None for no subscription."""
    from rclpy.qos import ReliabilityPolicy

    if publishers:
        return fit(publishers)
    is_reliable = now is not None and now.reliability == ReliabilityPolicy.RELIABLE
    return now if is_reliable else None  # nothing of a RELIABLE publisher is lost


def is_equal(one: object, other: object) -> bool:
    """Whether two profiles, or None, connect to the same publishers in the same way."""
    return _policies(one) == _policies(other)


def _policies(profile: Any) -> object:
    return None if profile is None else (profile.reliability, profile.durability)
