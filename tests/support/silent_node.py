"""`python -m tests.support.silent_node`: a node that answers nothing, until a line on stdin."""

from __future__ import annotations

import sys

import rclpy


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("silent")
    print("ready", flush=True)
    sys.stdin.readline()
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
