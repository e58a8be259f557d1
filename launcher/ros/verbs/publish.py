"""`topic pub`: checks everything, then publishes."""

from __future__ import annotations

import itertools
import math
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from launcher.base.errors import ExitCode
from launcher.base.ros_errors import VerbError
from launcher.packages.distribution import has_fast_dds_3
from launcher.posix.json_output import print_line
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.from_yaml import Content, documents, fill, parse
from launcher.ros.messages.interfaces import load_message
from launcher.ros.messages.to_yaml import to_plain
from launcher.ros.snapshot.qos_matching import Mismatch
from launcher.ros.snapshot.ros_graph import Direction, Endpoint
from launcher.ros.topics import qos
from launcher.ros.topics.clock import WallClock, clock_of
from launcher.ros.topics.listener import full_topic
from launcher.ros.topics.qos import QosOptions
from launcher.ros.topics.unmatched import Unmatched
from launcher.ros.verb import GraphAccess, named_node, observing, say, to_json_plain, warn
from launcher.ros.verbs.streams import until_interrupted

if TYPE_CHECKING:
    from rclpy.publisher import Publisher

_POLL_S = 0.02
_DELIVERY_S = 10.0
_PROFILES = os.path.dirname(qos.__file__)


def participant_profile() -> str:
    return os.path.join(_PROFILES, "publisher_3.xml" if has_fast_dds_3() else "publisher.xml")


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishOptions:
    """What `topic pub` was asked for; without a `limit` it publishes until Ctrl-C.

    With a `yaml_file` it publishes each document of it instead of the `values`, and ends.
    `subscriptions` is how many to wait for, `print_each` the N of each Nth message.
    """

    access: GraphAccess
    topic: str
    type: str
    values: str
    yaml_file: str | None
    qos: QosOptions
    rate_hz: float
    limit: int | None
    print_each: int
    subscriptions: int
    max_wait_s: float | None
    keep_alive_s: float
    node_name: str | None
    use_sim_time: bool
    json: bool


def publish(options: PublishOptions) -> int:
    from rclpy.qos import QoSProfile

    contents, has_end = _contents(options), options.limit is not None or bool(options.yaml_file)
    name = full_topic(options.topic)
    profile = qos.from_options(options.qos, QoSProfile(depth=10))
    clock = clock_of(simulated=options.use_sim_time)
    with (
        until_interrupted(is_end=False),
        observing(options.access, profile=participant_profile()) as observer,
        named_node(observer, options.node_name) as node,
    ):
        clock.start(observer)
        publisher = node.create_publisher(load_message(options.type), name, profile)
        own = qos.endpoint_of(profile, Direction.PUBLISHER, name, options.type, node="this command")
        _await_subscriptions(observer, publisher, options, own)
        with until_interrupted(is_end=not has_end):
            _loop(clock, publisher, contents, options)
        if has_end:
            _await_delivery(publisher, options.keep_alive_s)
    return ExitCode.OK


def _contents(options: PublishOptions) -> Iterable[Content]:
    """The messages in their order, as many as there are; VerbError."""
    kind, path = with_library(load_message(options.type)), options.yaml_file
    if path is None:
        message = kind()
        return itertools.repeat(Content(message, fill(message, parse(options.values))))
    found = _documents_of(path, kind, options.limit)
    first = next(found, None)
    if first is None:
        raise VerbError(f"{path}: no message in it")
    # A pipe may have no end; of a file, nothing is published if a document is wrong.
    return [first, *found] if os.path.isfile(path) else itertools.chain([first], found)


def _documents_of(path: str, kind: Any, limit: int | None) -> Iterator[Content]:
    for number, text in itertools.islice(enumerate(documents(path), 1), limit):
        message = kind()
        try:
            stamps = fill(message, parse(text))
        except VerbError as error:
            place = f"{path}, document {number}: {error.message}"
            raise VerbError(place, hint=error.hint) from None
        yield Content(message, stamps)


def _await_delivery(publisher: Publisher, keep_alive_s: float) -> None:
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
    observer: Observer, publisher: Publisher, options: PublishOptions, own: Endpoint
) -> None:
    """Return when there are as many as wanted; VerbError if that takes too long."""
    wanted, limit_s = options.subscriptions, options.max_wait_s
    printed_s, unmatched = None, Unmatched()
    end = math.inf if limit_s is None else time.monotonic() + limit_s
    while (there := publisher.get_subscription_count()) < wanted:
        now = time.monotonic()
        if printed_s is None or now - printed_s >= 1.0:
            waiting = f"Waiting for at least {wanted} matching subscription(s)..."
            say(waiting, json=options.json)
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
    publisher: Publisher,
    contents: Iterable[Content],
    options: PublishOptions,
) -> None:
    if not options.json:
        print("publisher: beginning loop", flush=True)
    due = clock.elapsed_s()
    for count, content in enumerate(itertools.islice(contents, options.limit), 1):
        clock.sleep_until(due)
        due = max(due + 1.0 / options.rate_hz, clock.elapsed_s() - 1.0)  # do not catch up for ever
        content.stamp(clock.now_ns() or 0)
        publisher.publish(content.message)
        if count % options.print_each == 0:
            _report(count, content.message, options)


def _report(number: int, message: Any, options: PublishOptions) -> None:
    if options.json:
        plain = to_json_plain(to_plain(message))
        print_line({"topic": full_topic(options.topic), "number": number, "message": plain})
    else:
        print(f"publishing #{number}: {message!r}\n", flush=True)
