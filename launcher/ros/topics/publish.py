"""`topic pub`: checks everything, then publishes."""

from __future__ import annotations

import sys
import time
from typing import Any

from launcher.command_line import Parsed
from launcher.errors import ExitCode
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.from_yaml import Stamp, fill, parse
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.graph import Direction, Endpoint
from launcher.ros.snapshot.qos_matching import explain, mismatches
from launcher.ros.topics import qos
from launcher.ros.topics.listener import full_topic
from launcher.ros.topics.streams import until_interrupted
from launcher.ros.verb import observing, warn

_POLL_S = 0.02
_DELIVERY_S = 10.0


def publish(options: Parsed) -> int:
    from rclpy.qos import QoSProfile

    message = with_library(load_message(options.message_type))()
    stamps = fill(message, parse(sys.stdin.read() if options.stdin else options.values))
    name = full_topic(options.topic_name)
    profile = qos.from_options(options, QoSProfile(depth=10))
    with until_interrupted(), observing(options) as observer:
        publisher = observer.node.create_publisher(type(message), name, profile)
        own = qos.endpoint_of(
            profile, Direction.PUBLISHER, name, options.message_type, node="this command"
        )
        _await_subscriptions(observer, publisher, _wanted(options), own)
        _loop(observer, publisher, message, stamps, options)
        if options.once or options.times:
            _await_delivery(publisher, options.keep_alive)
    return ExitCode.OK


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


def _wanted(options: Parsed) -> int:
    if options.wait_matching_subscriptions is not None:
        return int(options.wait_matching_subscriptions)
    return 1 if options.once or options.times else 0


def _await_subscriptions(observer: Observer, publisher: Any, wanted: int, own: Endpoint) -> None:
    printed_s = explained = None
    while publisher.get_subscription_count() < wanted:
        now = time.monotonic()
        if printed_s is None or now - printed_s >= 1.0:
            print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
            printed_s = now
            there = [e for e in observer.endpoints(own.topic) if not e.is_publisher]
            text = _why_unmatched([*there, own])
            if text and text != explained:
                warn(text)
                explained = text
        time.sleep(_POLL_S)


def _why_unmatched(endpoints: list[Endpoint]) -> str | None:
    """The mismatches, with the options of ours that repair them; None if there are none."""
    found = mismatches(endpoints)
    if not found:
        return None
    options = qos.publisher_options(found)
    hint = f"\nhint: {' '.join(options)}" if options else ""
    return explain(endpoints) + hint


def _loop(
    observer: Observer, publisher: Any, message: Any, stamps: list[Stamp], options: Parsed
) -> None:
    print("publisher: beginning loop", flush=True)
    limit = 1 if options.once else options.times
    count, due = 0, time.monotonic()
    while limit is None or count < limit:
        time.sleep(max(0.0, due - time.monotonic()))
        due = max(due + 1.0 / options.rate, time.monotonic() - 1.0)  # do not catch up for ever
        count += 1
        if stamps:
            now = observer.node.get_clock().now().to_msg()
            for stamp in stamps:
                stamp(now)
        publisher.publish(message)
        if count % options.print == 0:
            print(f"publishing #{count}: {message!r}\n", flush=True)
