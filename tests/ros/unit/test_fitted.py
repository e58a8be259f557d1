"""One subscription replaces another: each message comes once, and the profile fits."""

from __future__ import annotations

import contextlib
from collections import deque
from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from launcher.ros.snapshot.ros_graph import Direction, Endpoint
from launcher.ros.topics import fitted as module
from launcher.ros.topics.fitted import Fitted, Numbers
from launcher.ros.topics.raw import RawMessage

KEPT = ("RELIABLE", "TRANSIENT_LOCAL")
RELIABLE = ("RELIABLE", "VOLATILE")
WEAK = ("BEST_EFFORT", "VOLATILE")


def publisher(gid: str, policies: tuple[str, str]) -> Endpoint:
    return Endpoint(
        topic="/t",
        node="/n",
        direction=Direction.PUBLISHER.value,
        type="std_msgs/msg/String",
        reliability=policies[0],
        durability=policies[1],
        gid=gid,
    )


def message(sequence: int, gid: bytes = b"a") -> RawMessage:
    return RawMessage(b"%d" % sequence, gid, sequence, 0, 0)


class Queue:
    """A subscription, and what has arrived for it."""

    def __init__(self, profile: QoSProfile) -> None:
        self.policies = (profile.reliability.name, profile.durability.name)
        self.waiting: deque[RawMessage] = deque()
        self.is_destroyed = False

    @property
    def handle(self) -> contextlib.AbstractContextManager[Queue]:
        return contextlib.nullcontext(self)


class Middleware:
    """As node and taker: what `Fitted` asks of them."""

    def __init__(self) -> None:
        self.queues: list[Queue] = []

    def create(self, profile: QoSProfile) -> Queue:
        self.queues.append(Queue(profile))
        return self.queues[-1]

    def take(self, handle: contextlib.nullcontext[Queue]) -> RawMessage | None:
        waiting = handle.enter_result.waiting
        return waiting.popleft() if waiting else None

    def destroy_subscription(self, queue: Queue) -> None:
        queue.is_destroyed = True

    @property
    def open(self) -> list[tuple[str, str]]:
        return [queue.policies for queue in self.queues if not queue.is_destroyed]


@pytest.fixture
def middleware(monkeypatch: pytest.MonkeyPatch) -> Middleware:
    monkeypatch.setattr(module, "OVERLAP_S", 3600.0)
    return Middleware()


@pytest.fixture
def fitted(middleware: Middleware) -> Fitted:
    node: Any = middleware
    return Fitted(node, node, middleware.create)


def taken(fitted: Fitted) -> list[bytes]:
    return [raw.data for raw, _ in fitted.take(100)]


def test_without_publishers_there_is_no_subscription(middleware: Middleware, fitted: Fitted):
    fitted.fit([])
    assert (middleware.open, taken(fitted), fitted.profile) == ([], [], None)
    fitted.fit([publisher("a", KEPT)])
    assert middleware.open == [KEPT]


def test_a_weak_subscription_ends_with_its_publishers_and_a_reliable_one_stays(
    middleware: Middleware, fitted: Fitted
):
    fitted.fit([publisher("a", WEAK)])
    middleware.queues[0].waiting.append(message(1))
    fitted.fit([])
    assert (taken(fitted), middleware.open, fitted.profile) == ([b"1"], [], None)
    fitted.fit([publisher("b", KEPT)])
    fitted.fit([])
    assert middleware.open == [KEPT]
    assert fitted.profile.durability == DurabilityPolicy.TRANSIENT_LOCAL


def test_the_profile_is_as_strong_as_all_publishers_allow(middleware: Middleware, fitted: Fitted):
    kept, reliable, weak = (publisher(p[0] + p[1], p) for p in (KEPT, RELIABLE, WEAK))
    for publishers in ([kept], [kept, reliable], [kept, reliable, weak], [reliable], [reliable]):
        fitted.fit(publishers)
    assert [queue.policies for queue in middleware.queues] == [KEPT, RELIABLE, WEAK, RELIABLE]
    assert fitted.profile.reliability == ReliabilityPolicy.RELIABLE


def test_messages_come_once_and_in_order_from_both_subscriptions(
    middleware: Middleware, fitted: Fitted
):
    fitted.fit([publisher("a", RELIABLE)])
    middleware.queues[0].waiting.extend(map(message, (1, 2)))
    assert taken(fitted) == [b"1", b"2"]
    fitted.fit([publisher("a", RELIABLE), publisher("b", WEAK)])
    middleware.queues[0].waiting.extend(map(message, (3, 4)))
    middleware.queues[1].waiting.extend([message(4), message(5), message(4, b"b")])
    assert taken(fitted) == [b"3", b"4", b"5", b"4"]
    fitted.close()
    assert middleware.open == []


def test_a_replaced_subscription_ends_when_the_other_one_is_known(
    middleware: Middleware, fitted: Fitted, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(module, "OVERLAP_S", 0.0)
    fitted.fit([publisher("a", KEPT)])
    fitted.fit([publisher("a", KEPT), publisher("b", WEAK)])
    middleware.queues[0].waiting.append(message(1))
    assert (taken(fitted), middleware.open) == ([b"1"], [WEAK])


def test_lost_messages_are_counted_for_each_publisher():
    numbers = Numbers()
    found = [numbers.missed(message(n, gid)) for n, gid in ((5, b"a"), (8, b"a"), (9, b"b"))]
    assert found == [0, 2, 0]
    assert [numbers.missed(message(n)) for n in (8, 7, 9)] == [None, None, 0]
    uncounted = message(2**64 - 1)
    assert [numbers.missed(uncounted) for _ in range(2)] == [0, 0]


def test_a_message_that_has_waited_for_one_sent_again_is_not_older_than_that(
    middleware: Middleware, fitted: Fitted
):
    fitted.fit([publisher("a", RELIABLE)])
    second = 10**9
    arrived = [7 * second, 9 * second, 8 * second, 10 * second]  # the second one was sent again
    middleware.queues[0].waiting.extend(
        message(n)._replace(received_ns=ns) for n, ns in enumerate(arrived)
    )

    received = [raw.received_ns // second for raw, _ in fitted.take(100)]
    assert received == [7, 9, 9, 10]


def test_a_clock_that_was_set_back_is_believed(middleware: Middleware, fitted: Fitted):
    fitted.fit([publisher("a", RELIABLE)])
    middleware.queues[0].waiting.extend(
        message(n)._replace(received_ns=ns) for n, ns in enumerate([10**15, 5, 6])
    )

    assert [raw.received_ns for raw, _ in fitted.take(100)] == [10**15, 5, 6]
