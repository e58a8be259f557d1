"""`python -m tests.support.hosts.first_number TOPIC`: prints the first Int32 that it receives."""

from __future__ import annotations

import sys

import rclpy
from rclpy.node import Node
from std_msgs.msg import Int32


def main() -> None:
    rclpy.init()
    node = Node("hearer")
    heard: list[int] = []
    node.create_subscription(Int32, sys.argv[1], lambda message: heard.append(message.data), 10)
    while not heard:
        rclpy.spin_once(node)
    print(heard[0], flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
