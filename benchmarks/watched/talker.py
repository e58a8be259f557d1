"""A node with many topics: `talker.py TOPICS RATE_HZ`, with its name from the command line."""

from __future__ import annotations

import contextlib
import sys

import rclpy
from geometry_msgs.msg import PointStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class Talker(Node):
    """Publishes all of its topics at this rate; `value` is only there to be asked for."""

    def __init__(self, topics: int, rate_hz: float) -> None:
        super().__init__("talker")
        self.declare_parameter("value", 0.0)
        names = [f"{self.get_fully_qualified_name()}/topic_{number}" for number in range(topics)]
        self._outs = [self.create_publisher(PointStamped, name, 10) for name in names]
        self.create_timer(1 / rate_hz, self.publish)

    def publish(self) -> None:
        message = PointStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        for out in self._outs:
            out.publish(message)


def main() -> None:
    rclpy.init()
    node = Talker(int(sys.argv[1]), float(sys.argv[2]))
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
