"""A node that logs on three levels again and again: `python -m tests.support.logging_node`.

With `--service` its levels can be set while it runs; with `--twice` there are two nodes.
"""

from __future__ import annotations

import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def main() -> None:
    rclpy.init()
    names = ["logging_node", "second_node"] if "--twice" in sys.argv else ["logging_node"]
    nodes = [Node(name, enable_logger_service="--service" in sys.argv) for name in names]

    def log() -> None:
        for node in nodes:
            for logger in (node.get_logger(), node.get_logger().get_child("part")):
                logger.debug("finest")
                logger.info("usual")
                logger.error("worst")

    nodes[0].create_timer(0.1, log)
    executor = rclpy.executors.SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
