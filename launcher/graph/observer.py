"""Observer: takes a snapshot of the graph that this process's domain shows."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType

import rclpy
from rclpy.context import Context
from rclpy.node import Node

from launcher.graph.snapshot import Direction, Endpoint, Snapshot

OWN_NAME = "_launcher_observer"  # hidden, as everything that begins with an underscore
LOOK_S = 0.1


class Observer:
    """A hidden node of its own context; use with `with`."""

    def __enter__(self) -> Observer:
        self._context = Context()
        rclpy.init(context=self._context)
        self._node = Node(
            OWN_NAME,
            context=self._context,
            enable_rosout=False,
            start_parameter_services=False,
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._node.destroy_node()
        self._context.try_shutdown()

    def snapshot(self) -> Snapshot:
        """What is known now; discovery may still be on its way."""
        nodes = {
            _full(name, namespace) for name, namespace in self._node.get_node_names_and_namespaces()
        }
        nodes.discard(f"/{OWN_NAME}")
        endpoints = [
            endpoint
            for topic, _ in self._node.get_topic_names_and_types()
            for endpoint in self._endpoints(topic)
        ]
        return Snapshot(nodes=tuple(sorted(nodes)), endpoints=tuple(sorted(endpoints)))

    def wait_for(self, fact: Callable[[Snapshot], bool], deadline_s: float) -> Snapshot:
        """The first snapshot for which `fact` holds; the last one at the deadline."""
        end = time.monotonic() + deadline_s
        while not fact(snapshot := self.snapshot()) and time.monotonic() < end:
            time.sleep(LOOK_S)
        return snapshot

    def _endpoints(self, topic: str) -> list[Endpoint]:
        both = (
            (Direction.PUBLISHER, self._node.get_publishers_info_by_topic(topic)),
            (Direction.SUBSCRIPTION, self._node.get_subscriptions_info_by_topic(topic)),
        )
        return [
            Endpoint(
                topic=topic,
                node=_full(info.node_name, info.node_namespace),
                direction=direction.value,
                type=info.topic_type,
                reliability=info.qos_profile.reliability.name,
                durability=info.qos_profile.durability.name,
            )
            for direction, infos in both
            for info in infos
            if info.node_name != OWN_NAME
        ]


def _full(name: str, namespace: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"
