"""The nodes of the watched system: `nodes.py source` and `nodes.py sink`."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from typing import Any

import rclpy
from geometry_msgs.msg import PointStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

RATE_HZ = 10.0
WORK_S = 0.015  # of processor time for a message
TOPICS = ("/a", "/b")


class Source(Node):
    """Publishes at 10 Hz. Parameters change what it does while it runs.

    `skip`: leaves out messages but every n-th; `leak`: MiB for each message; `value`: of the
    messages; `marker`: with this file, another start offers BEST_EFFORT.
    """

    def __init__(self) -> None:
        super().__init__("source")
        defaults = {"topic": "/a", "skip": 1, "leak": 0, "value": 1.0, "marker": ""}
        for name, value in defaults.items():
            self.declare_parameter(name, value)
        is_other = os.path.exists(self.value("marker"))
        reliability = ReliabilityPolicy.BEST_EFFORT if is_other else ReliabilityPolicy.RELIABLE
        profile = QoSProfile(depth=10, reliability=reliability)
        self._publisher = self.create_publisher(PointStamped, self.value("topic"), profile)
        self._count = 0
        self._kept: list[bytes] = []
        self.create_timer(1 / RATE_HZ, self.publish)

    def value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def publish(self) -> None:
        self._count += 1
        if self._count % self.value("skip"):
            return
        message = PointStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        end_s = time.thread_time() + WORK_S
        while time.thread_time() < end_s:
            pass
        message.point.x = self.value("value")
        self._publisher.publish(message)
        if size := self.value("leak"):
            self._kept.append(os.urandom(1024) * 1024 * size)


class Sink(Node):
    """Receives everything, RELIABLE."""

    def __init__(self) -> None:
        super().__init__("sink")
        for topic in TOPICS:
            self.create_subscription(PointStamped, topic, lambda message: None, 10)


def main() -> None:
    rclpy.init()
    node = Source() if sys.argv[1] == "source" else Sink()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
