"""Publish: `topic pub`, with everything checked before the first message leaves."""

from __future__ import annotations

import sys
import time
from typing import Any

from launcher.command_line import Parsed
from launcher.errors import ExitCode
from launcher.graph import profiles
from launcher.graph.from_yaml import Stamp, fill, parse
from launcher.graph.interfaces import full_type, load_message
from launcher.graph.listener import full_topic
from launcher.graph.matching import explain, mismatches
from launcher.graph.observer import Observer
from launcher.graph.snapshot import Direction, Endpoint
from launcher.graph.streams import until_interrupted
from launcher.graph.verb import looking, warn

_LOOK_S = 0.02
_DELIVERY_S = 10.0


def publish(options: Parsed) -> int:
    """Publish as the options say; the exit code."""
    from rclpy.qos import QoSProfile

    message = load_message(options.message_type)()
    stamps = fill(message, parse(sys.stdin.read() if options.stdin else options.values))
    name = full_topic(options.topic_name)
    profile = profiles.from_options(options, QoSProfile(depth=10))
    with until_interrupted(), looking(options) as observer:
        publisher = observer.node.create_publisher(type(message), name, profile)
        own = _own_endpoint(name, options.message_type, profile)
        _await_subscriptions(observer, publisher, _wanted(options), own)
        _loop(observer, publisher, message, stamps, options)
        if options.once or options.times:
            _await_delivery(publisher, options.keep_alive)
    return ExitCode.OK


def _await_delivery(publisher: Any, keep_alive_s: float) -> None:
    """Stay for a while, and longer if a subscription that asks for it has not got all yet.

    A publisher knows a subscription before the subscription knows it, and may have published.
    """
    from rclpy.duration import Duration

    time.sleep(keep_alive_s)
    end, slice_ = time.monotonic() + _DELIVERY_S, Duration(nanoseconds=100_000_000)
    while time.monotonic() < end and not publisher.wait_for_all_acked(slice_):
        pass  # so that Ctrl-C is heard between two slices


def _wanted(options: Parsed) -> int:
    if options.wait_matching_subscriptions is not None:
        return int(options.wait_matching_subscriptions)
    return 1 if options.once or options.times else 0


def _await_subscriptions(observer: Observer, publisher: Any, wanted: int, own: Endpoint) -> None:
    said_at = told = None
    while publisher.get_subscription_count() < wanted:
        now = time.monotonic()
        if said_at is None or now - said_at >= 1.0:
            print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
            said_at = now
            there = [e for e in observer.endpoints(own.topic) if not e.is_publisher]
            text = explain([*there, own]) if mismatches([*there, own]) else None
            if text and text != told:
                warn(text)
                told = text
        time.sleep(_LOOK_S)


def _own_endpoint(name: str, type_name: str, profile: Any) -> Endpoint:
    return profiles.endpoint_of(
        profile,
        topic=name,
        type_name=full_type(type_name),
        direction=Direction.PUBLISHER,
        node="this command",
    )


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
