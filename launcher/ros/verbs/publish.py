"""`topic pub`: checks everything, then publishes."""

from __future__ import annotations

import contextlib
import math
import os
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from launcher.base.errors import ExitCode, UsageError
from launcher.base.ros_errors import VerbError, name_fault
from launcher.ros.discovery.observer import Observer
from launcher.ros.helpers.clean_up import limited_clean_up
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.from_yaml import Stamp, fill, parse
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.graph import Direction, Endpoint
from launcher.ros.snapshot.qos_matching import Mismatch
from launcher.ros.topics import qos
from launcher.ros.topics.clock import WallClock, clock_of
from launcher.ros.topics.listener import full_topic
from launcher.ros.topics.unmatched import Unmatched
from launcher.ros.verb import observing, standard_input, warn
from launcher.ros.verbs.listening import qos_options
from launcher.ros.verbs.streams import until_interrupted

if TYPE_CHECKING:
    from launcher.base.command_line import Parsed

_POLL_S = 0.02
_DELIVERY_S = 10.0
_PROFILE = os.path.join(os.path.dirname(qos.__file__), "publisher.xml")


def publish(options: Parsed, limit: int | None, subscriptions: int) -> int:
    """Publish `limit` messages, or until Ctrl-C, once there are so many subscriptions."""
    from rclpy.qos import QoSProfile

    values = standard_input() if options.stdin else options.values
    message = with_library(load_message(options.message_type))()
    stamps = fill(message, parse(values))
    name = full_topic(options.topic_name)
    profile = qos.from_options(qos_options(options), QoSProfile(depth=10))
    clock = clock_of(simulated=options.use_sim_time)
    with (
        until_interrupted(is_end=False),
        observing(options, profile=_PROFILE) as observer,
        _node(observer, options.node_name) as node,
    ):
        clock.start(observer)
        publisher = node.create_publisher(type(message), name, profile)
        own = qos.endpoint_of(
            profile, Direction.PUBLISHER, name, options.message_type, node="this command"
        )
        _await_subscriptions(observer, publisher, subscriptions, options.max_wait_time_secs, own)
        with until_interrupted(is_end=limit is None):
            _loop(clock, publisher, message, stamps, limit, options)
        if limit is not None:
            _await_delivery(publisher, options.keep_alive)
    return ExitCode.OK


@contextlib.contextmanager
def _node(observer: Observer, name: str | None) -> Iterator[Any]:
    """The node that publishes: a hidden one, or one of this name."""
    from rclpy.exceptions import InvalidNodeNameException

    if name is None:
        yield observer.node
        return
    try:
        node = observer.companion(name)
    except InvalidNodeNameException as error:
        raise UsageError(f"--node-name: {name_fault(error)}") from None
    try:
        yield node
    finally:
        with limited_clean_up():
            node.destroy_node()


def _await_delivery(publisher: Any, keep_alive_s: float) -> None:
    """Stay for a while, and until RELIABLE subscriptions have received everything.

    A publisher discovers a subscription before the subscription discovers it, and may have
    published by then.
    """
    from rclpy.duration import Duration

    time.sleep(keep_alive_s)
    end, slice_ = time.monotonic() + _DELIVERY_S, Duration(nanoseconds=100_000_000)
    while time.monotonic() < end and not publisher.wait_for_all_acked(slice_):
        pass  # so that Ctrl-C is handled between two slices


def _await_subscriptions(
    observer: Observer, publisher: Any, wanted: int, limit_s: float | None, own: Endpoint
) -> None:
    """Return when there are as many as wanted; VerbError if that takes too long."""
    printed_s, unmatched = None, Unmatched()
    end = math.inf if limit_s is None else time.monotonic() + limit_s
    while (there := publisher.get_subscription_count()) < wanted:
        now = time.monotonic()
        if printed_s is None or now - printed_s >= 1.0:
            print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
            printed_s = now
            others = [e for e in observer.endpoints(own.topic) if not e.is_publisher]
            if text := unmatched.news([*others, own], _with_options):
                warn(text)
        if now >= end:
            raise VerbError(
                f"Timed out waiting for subscribers: Expected {wanted} subscribers but only got "
                f"{there} subscribers"
            )
        time.sleep(_POLL_S)


def _with_options(found: list[Mismatch], reasons: str) -> str:
    """The mismatches, with the options of ours that repair them."""
    options = qos.publisher_options(found)
    return f"{reasons}\nhint: {' '.join(options)}" if options else reasons


def _loop(
    clock: WallClock,
    publisher: Any,
    message: Any,
    stamps: list[Stamp],
    limit: int | None,
    options: Parsed,
) -> None:
    print("publisher: beginning loop", flush=True)
    count, due = 0, clock.elapsed_s()
    while limit is None or count < limit:
        clock.sleep_until(due)
        due = max(due + 1.0 / options.rate, clock.elapsed_s() - 1.0)  # do not catch up for ever
        count += 1
        if stamps:
            now = _message(clock.now_ns() or 0)
            for stamp in stamps:
                stamp(now)
        publisher.publish(message)
        if count % options.print == 0:
            print(f"publishing #{count}: {message!r}\n", flush=True)


def _message(now_ns: int) -> Any:
    from builtin_interfaces.msg import Time

    return Time(sec=now_ns // 1_000_000_000, nanosec=now_ns % 1_000_000_000)
