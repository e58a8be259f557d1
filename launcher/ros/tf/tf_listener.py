"""Receives transforms as an rclpy node does, and says who broadcasts them, which tf2 does not."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from launcher.base.ros_errors import VerbError
from launcher.packages import unbuilt
from launcher.packages.package_origins import build_command
from launcher.ros.messages.interfaces import load_message, none_installed
from launcher.ros.snapshot.ros_graph import Direction
from launcher.ros.tf import tf_message
from launcher.ros.tf.frame_tree import TfSample
from launcher.ros.topics.listener import Listener, ReceivedMessage, full_topic
from launcher.ros.topics.qos import LISTEN_DEPTH, QosOptions
from launcher.ros.verb import warn
from launcher.ros.verbs.awaited_topics import TopicSubscriber

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

_PACKAGE = tf_message.TYPE.partition("/")[0]
_INTRODUCTION_S = 0.3  # a publisher may be known before its node
_PERIOD_S = 0.004


def require_type() -> Any:
    """The class of the messages; VerbError with the commands that build it."""
    try:
        return load_message(tf_message.TYPE)
    except VerbError:
        text = f"transforms are sent as {tf_message.TYPE}, which is not installed"
        if is_without_ros := none_installed():
            raise VerbError(text, hint=is_without_ros) from None
        steps = f"it has no wheel; build it in a workspace: {build_command(_PACKAGE)}"
        raise VerbError(text, hint=unbuilt.hint(_PACKAGE, os.environ) or steps) from None


class TfListener:
    """Subscriptions to a topic of moving and one of static transforms."""

    def __init__(self, observer: Observer, topics: Sequence[str], spin_time_s: float) -> None:
        self._observer = observer
        self._listener = Listener(observer, raw=True)
        self._static = full_topic(topics[1])
        self._nodes: dict[str, str] = {}
        self._asked_s = 0.0
        self._has_warned = False
        subscriber = TopicSubscriber(
            observer, self._listener, QosOptions(), spin_time_s, json=False
        )
        for name in topics:
            target = subscriber.first_target(name, tf_message.TYPE)
            assert target is not None  # its type is given
            profile = _latched() if target.name == self._static else None
            self._listener.subscribe(target, profile)

    def samples(self, tick: Callable[[], bool]) -> Iterator[TfSample]:
        """All messages until `tick`, which is called every few milliseconds, returns False."""
        for received in self._listener.samples(tick):
            try:
                transforms = tf_message.read(received.message)
            except ValueError as error:
                if not self._has_warned:
                    warn(f"{received.topic}: {error}")
                self._has_warned = True
                continue
            is_static = received.topic == self._static
            yield TfSample(received.received_ns, is_static, self._broadcaster(received), transforms)

    def close(self) -> None:
        self._listener.close()

    def _broadcaster(self, received: ReceivedMessage) -> str:
        """The node; of a new publisher it is awaited, who may never send again."""
        gid = received.publisher.hex(".")
        if gid not in self._nodes:
            wait_until_s = time.monotonic() + _INTRODUCTION_S
            while not self._nodes.get(gid) and time.monotonic() < wait_until_s:
                time.sleep(_PERIOD_S)
                self._ask(received.topic)
            self._nodes.setdefault(gid, "")
        elif not self._nodes[gid] and time.monotonic() >= self._asked_s:
            self._ask(received.topic)
        return self._nodes[gid]

    def _ask(self, topic: str) -> None:
        self._asked_s = time.monotonic() + _INTRODUCTION_S
        for info in self._observer.infos(topic, Direction.PUBLISHER):
            if info.node:
                self._nodes[info.gid] = info.node


def _latched() -> Any:
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=LISTEN_DEPTH,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        reliability=ReliabilityPolicy.RELIABLE,
    )
