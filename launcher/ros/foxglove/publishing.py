"""Topics that clients publish."""

from __future__ import annotations

import time

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

from launcher.base import strict_json
from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.observer import Observer
from launcher.ros.foxglove import protocol
from launcher.ros.foxglove.feeds import reason
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.from_yaml import fill, stamp_all
from launcher.ros.messages.interfaces import full_type, load_message
from launcher.ros.snapshot.ros_graph import Direction
from launcher.ros.topics.listener import full_topic

_DEPTH = 10
_CONNECT_S = 0.5  # the subscriptions that are there get the first message, too
_PERIOD_S = 0.01


class Publication:
    """A channel of a client, and the publisher for it."""

    def __init__(self, observer: Observer, topic: str, type_name: str, encoding: str) -> None:
        """VerbError; takes as long as it takes to connect to the subscriptions."""
        if encoding not in protocol.ENCODINGS:
            known = " and ".join(protocol.ENCODINGS)
            raise VerbError(f"encoding '{encoding}' cannot be published; {known} can")
        self.topic = full_topic(topic)
        self._observer = observer
        self._is_json = encoding == "json"
        self._kind = with_library(load_message(full_type(type_name)))
        subscriptions = observer.infos(self.topic, Direction.SUBSCRIPTION)
        durabilities = {info.durability for info in subscriptions}
        profile = QoSProfile(depth=_DEPTH)
        if DurabilityPolicy.TRANSIENT_LOCAL.name in durabilities:
            profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
        try:
            self._publisher = observer.node.create_publisher(self._kind, self.topic, profile)
        except RuntimeError as error:  # of rclpy: this process has the topic with another type
            raise VerbError(f"cannot publish: {reason(error)}") from None
        deadline = time.monotonic() + _CONNECT_S
        while time.monotonic() < deadline:
            if self._publisher.get_subscription_count() >= len(subscriptions):
                break
            time.sleep(_PERIOD_S)

    def publish(self, payload: bytes) -> None:
        """VerbError if it is no message of the type, which subscriptions could not take."""
        try:
            if self._is_json:
                message = self._kind()
                stamps = fill(message, strict_json.loads(payload))
                stamp_all(stamps, self._observer.node.get_clock().now().to_msg())
                self._publisher.publish(message)
            else:
                deserialize_message(payload, self._kind)
                self._publisher.publish(payload)
        except VerbError:
            raise
        except Exception as error:  # of rclpy: of several types
            raise VerbError(f"no {self._kind.__name__}: {reason(error)}") from None

    def close(self) -> None:
        self._observer.node.destroy_publisher(self._publisher)
