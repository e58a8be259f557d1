"""Ten nodes for the tests of recordings: `python -m tests.smoke.process.ten_nodes ROLE`.

Each has something that a recording must notice, or must not rely on.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import random
import string
import sys
import time
import uuid
from collections.abc import Callable

import rclpy
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int32, String
from std_srvs.srv import Empty, SetBool

BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PUNCTUAL = QoSProfile(depth=10, deadline=Duration(seconds=20))


def beat(node: Node, topic: str, period_s: float, qos: QoSProfile | int = 10) -> None:
    publisher = node.create_publisher(Int32, topic, qos)
    node.create_timer(period_s, lambda: publisher.publish(Int32(data=1)))


def steady() -> Node:
    node = Node("steady")
    beat(node, "steady", 1.0)
    node.get_logger().info("steady is ready")
    return node


def fast() -> Node:
    node = Node("fast")
    beat(node, "fast", 0.05, BEST_EFFORT)
    return node


def slow() -> Node:
    node = Node("slow")
    beat(node, "slow", 2.5, KEPT)
    return node


def keeper() -> Node:
    """Publishes once, for whoever comes."""
    node = Node("keeper")
    node.create_publisher(String, "map", KEPT).publish(String(data="all of it"))
    return node


def switch() -> Node:
    """Its services have effects: nobody may call them for a look."""

    def fail(request: object, response: object) -> object:
        node.get_logger().error("called")
        return response

    node = Node("switch")
    node.create_service(SetBool, "switch", fail)
    node.create_service(Empty, "~/reset", fail)
    node.get_logger().info(f"switch started with pid {os.getpid()}")
    return node


def engine() -> Node:
    """A lifecycle node that makes itself active."""
    node = LifecycleNode("engine")
    beats = node.create_lifecycle_publisher(Int32, "beats", 10)
    node.create_timer(0.2, lambda: beats.publish(Int32(data=1)))
    node.trigger_configure()
    node.trigger_activate()
    return node


def mixed() -> Node:
    """Publishes where `steady` does, with another quality of service."""
    node = Node("mixed")
    beat(node, "shared", 0.5, BEST_EFFORT)
    node.create_subscription(Int32, "steady", lambda _: None, 10)
    node.create_subscription(Int32, "fast", lambda _: None, 10)  # RELIABLE: gets nothing
    return node


def anonymous() -> Node:
    """Its names and its first line are others in each run."""
    node = Node(f"anonymous_{os.getpid()}_{time.time_ns()}")
    beat(node, f"private_{uuid.uuid4().hex}", 0.5)
    beat(node, "shared", 0.5)
    node.get_logger().info("".join(random.choices(string.ascii_letters, k=20)))
    return node


def moody() -> Node:
    """Changes its mind: ten messages a second for 4 s, and then one a second for 4 s.

    Messages at random times would look regular in one of a thousand recordings.
    """
    node = Node("moody")
    publisher = node.create_publisher(Int32, "moods", 10)
    ticks = itertools.count()

    def talk() -> None:
        tick = next(ticks)
        if tick % 80 < 40 or tick % 10 == 0:
            publisher.publish(Int32(data=1))

    node.create_timer(0.1, talk)
    return node


def late() -> Node:
    """Is started late; has a namespace."""
    node = Node("late", namespace="/site")
    beat(node, "late", 0.5, PUNCTUAL)
    node.create_subscription(Int32, "late", lambda _: None, PUNCTUAL)
    return node


ROLES: dict[str, Callable[[], Node]] = {
    "steady": steady,
    "fast": fast,
    "slow": slow,
    "keeper": keeper,
    "switch": switch,
    "engine": engine,
    "mixed": mixed,
    "anonymous": anonymous,
    "moody": moody,
    "late": late,
}


def main() -> None:
    """Spin until interrupted."""
    rclpy.init()
    node = ROLES[sys.argv[1]]()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
