"""`python -m tests.support.hosts.acquaintance NAME`: publishes its name, and prints others.

Publishes NAME ten times a second on `/names`, and prints each name that it receives: at once, and
then every 20 messages of it.
"""

from __future__ import annotations

import sys
from collections import Counter

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String

EVERY = 20


def main() -> None:
    rclpy.init()
    node = Node(sys.argv[1])
    heard: Counter[str] = Counter()

    def hear(message: String) -> None:
        if heard[message.data] % EVERY == 0:
            print(message.data, flush=True)
        heard[message.data] += 1

    publisher = node.create_publisher(String, "/names", 10)
    node.create_subscription(String, "/names", hear, 10)
    node.create_timer(0.1, lambda: publisher.publish(String(data=sys.argv[1])))
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
