"""`python -m tests.support.number_publisher TOPIC COUNT RATE [RELIABILITY [BYTES]]`: counts up.

With a number of bytes it publishes texts of this length.

Prints `ready`, waits for a subscription, publishes, prints the seconds it took when RELIABLE
subscriptions have everything, and stays until its stdin is closed. The node is called as the topic.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int32, String

BURST_S = 0.01
SLICE = Duration(nanoseconds=100_000_000)


def publish(
    node: Node, topic: str, count: int, rate: int, reliability: str = "RELIABLE", size: int = 0
) -> None:
    kind = String if size else Int32
    profile = QoSProfile(depth=min(count, 10_000), reliability=ReliabilityPolicy[reliability])
    publisher = node.create_publisher(kind, topic, profile)
    print("ready", flush=True)
    while rclpy.ok() and publisher.get_subscription_count() < 1:
        time.sleep(BURST_S)
    start = time.monotonic()
    for number in range(count):
        publisher.publish(String(data="x" * size) if size else Int32(data=number))
        ahead_s = number / rate - (time.monotonic() - start)
        if ahead_s > BURST_S:
            time.sleep(ahead_s)
    took_s = time.monotonic() - start
    while rclpy.ok() and not publisher.wait_for_all_acked(SLICE):
        pass
    print(took_s, flush=True)


def main() -> None:
    rclpy.init()
    node = Node(sys.argv[1])
    ended = threading.Event()

    def watch_input() -> None:
        sys.stdin.read()
        ended.set()
        rclpy.try_shutdown()

    threading.Thread(target=watch_input, daemon=True).start()
    # an input that ends before everything was published is no error
    with contextlib.suppress(rclpy._rclpy_pybind11.RCLError):
        topic, count, rate, *rest = sys.argv[1:]
        publish(node, topic, int(count), int(rate), *rest[:1], *map(int, rest[1:]))
    ended.wait()
    node.destroy_node()


if __name__ == "__main__":
    main()
