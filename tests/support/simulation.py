"""A simulation that runs ten times as fast as the clock of the machine, with nodes in it.

`python -m tests.support.simulation` prints `ready` and runs until its stdin is closed.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PointStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int32, String

SPEED = 10
AGE_S = 500  # of the stamps, in simulated seconds
BEGIN_NS = 1_000_000_000_000
LATCHED = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def stamp(nanoseconds: int) -> Time:
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


class Simulation(Node):
    """Publishes at 20 Hz of the machine, 2 Hz of the simulation; `latched` has a history."""

    def __init__(self) -> None:
        super().__init__("simulation")
        self._started_ns = time.monotonic_ns()
        self._ticks = self.create_publisher(Clock, "/clock", 10)
        self._texts = self.create_publisher(String, "texts", 10)
        self._points = self.create_publisher(PointStamped, "points", 10)
        self._latched = self.create_publisher(Int32, "latched", LATCHED)
        for number in range(50):
            self._latched.publish(Int32(data=number))
        self.create_timer(0.005, self._tick)
        self.create_timer(0.05, self._talk)
        self.create_timer(1.0, lambda: self._latched.publish(Int32(data=-1)))

    def _simulated_ns(self) -> int:
        return BEGIN_NS + SPEED * (time.monotonic_ns() - self._started_ns)

    def _tick(self) -> None:
        self._ticks.publish(Clock(clock=stamp(self._simulated_ns())))

    def _talk(self) -> None:
        self._texts.publish(String(data="text"))
        point = PointStamped()
        point.header.stamp = stamp(self._simulated_ns() - AGE_S * 10**9)
        self._points.publish(point)


def main() -> None:
    """Spin until stdin ends."""
    rclpy.init()
    node = Simulation()
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):  # stdin has ended
        rclpy.spin(node)
    node.destroy_node()


if __name__ == "__main__":
    main()
