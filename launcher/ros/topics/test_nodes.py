"""Nodes for tests, as in launch_testing_ros: wait for messages, spin, pass messages on."""

from __future__ import annotations

import contextlib
import random
import string
import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

import rclpy
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

from launcher.language.naming import public


@public("launch_testing_ros.wait_for_topics")
class WaitForTopics:
    """Subscribes to topics with a node in a separate context.

    `trigger(node, ...)` is called once there is a publisher, with the arguments of `wait`. As a
    context manager it waits at the beginning, with a RuntimeError after `timeout` seconds.
    """

    def __init__(
        self,
        topic_tuples: Iterable[tuple[str, Any]],
        timeout: float = 5.0,
        messages_received_buffer_length: int | None = 10,
        trigger: Callable[..., object] | None = None,
        node_namespace: str | None = None,
        qos_profile: Any = 10,
    ) -> None:
        if trigger is not None and not callable(trigger):
            raise TypeError("The passed trigger is not callable")
        self.topic_tuples = list(topic_tuples)
        self.timeout = timeout
        self.messages_received_buffer_length = messages_received_buffer_length
        self.trigger = trigger
        self.node_namespace = node_namespace
        self.qos_profile = qos_profile
        self._messages: dict[str, deque[Any]] = {}
        self._received: set[str] = set()
        self._all_received = threading.Event()
        self._publisher_seen = threading.Event()
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        name = "_test_node_" + "".join(random.choices(string.ascii_letters + string.digits, k=10))
        self._node = rclpy.create_node(name, context=self._context, namespace=node_namespace)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def wait(self, *args: Any, **kwargs: Any) -> bool:
        """Whether each topic has a new message within `timeout` seconds."""
        self._all_received.clear()
        self._received.clear()
        for topic, kind in self.topic_tuples:
            if topic in self._messages:
                self._messages[topic].clear()
            else:
                self._subscribe(topic, kind)
        self._publisher_seen.wait(self.timeout)
        if self.trigger is not None:
            self.trigger(self._node, *args, **kwargs)
        return self._all_received.wait(self.timeout)

    def shutdown(self) -> None:
        self._context.try_shutdown()
        self._thread.join()
        self._node.destroy_node()

    def topics_received(self) -> set[str]:
        return set(self._received)

    def topics_not_received(self) -> set[str]:
        return self._messages.keys() - self._received

    def received_messages(self, topic_name: str) -> list[Any]:
        """The last messages of a topic, at most `messages_received_buffer_length`."""
        if topic_name not in self._messages:
            raise KeyError(f"No messages received for topic: {topic_name}")
        return list(self._messages[topic_name])

    def _subscribe(self, topic: str, kind: Any) -> None:
        messages: deque[Any] = deque(maxlen=self.messages_received_buffer_length)
        self._messages[topic] = messages

        def received(message: Any) -> None:
            messages.append(message)
            self._received.add(topic)
            if self._received >= {name for name, _ in self.topic_tuples}:
                self._all_received.set()

        self._node.create_subscription(
            kind,
            topic,
            received,
            self.qos_profile,
            event_callbacks=SubscriptionEventCallbacks(matched=self._matched),
        )

    def _matched(self, info: Any) -> None:
        if info.current_count:
            self._publisher_seen.set()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def __enter__(self) -> WaitForTopics:
        if not self.wait():
            missing = self.topics_not_received()
            self.shutdown()
            raise RuntimeError("Did not receive messages on these topics: ", missing)
        return self

    def __exit__(self, *exception: object) -> None:
        self.shutdown()


@public("launch_testing_ros.message_pump")
class MessagePump:
    """Spins a node in a thread."""

    def __init__(self, node: Any, context: Any = None) -> None:
        self._node = node
        self._context = context
        self._goes_on = True
        self._thread = threading.Thread(target=self._spin, name="msg_pump_thread")

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._goes_on = False
        self._thread.join(timeout=5.0)
        if self._thread.is_alive():
            raise Exception("Timed out waiting for message pump to stop")

    def _spin(self) -> None:
        executor = SingleThreadedExecutor(context=self._context)
        executor.add_node(self._node)
        while self._goes_on:
            executor.spin_once(timeout_sec=0.2)
        executor.remove_node(self._node)


@public("launch_testing_ros.data_republisher")
class DataRepublisher:
    """Publishes what `transform_fn` makes of each message of a topic, unless it is None."""

    def __init__(
        self,
        node: Any,
        listen_topic: str,
        publish_topic: str,
        msg_type: Any,
        transform_fn: Callable[[Any], Any],
    ) -> None:
        self._node = node
        self._transform = transform_fn
        self._received = 0
        self._republished: list[Any] = []
        self._publisher = node.create_publisher(msg_type, publish_topic, 10)
        self._subscriber = node.create_subscription(msg_type, listen_topic, self._take, 10)

    def shutdown(self) -> None:
        self._node.destroy_subscription(self._subscriber)
        self._node.destroy_publisher(self._publisher)

    def get_num_received(self) -> int:
        return self._received

    def get_num_republished(self) -> int:
        return len(self._republished)

    def get_republished(self) -> list[Any]:
        """The messages that were passed on, as they came."""
        return self._republished

    def _take(self, message: Any) -> None:
        self._received += 1
        changed = self._transform(message)
        if changed is not None:
            self._republished.append(message)
            self._publisher.publish(changed)
