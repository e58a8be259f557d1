"""Writes in all ways, often and at the same time, then ends: `talkative_node.py NAME LINES`."""

from __future__ import annotations

import os
import sys
import threading

import rclpy
from rclpy.node import Node


def write_pieces(name: str, lines: int) -> None:
    """As libraries in C do it: a line in several writes."""
    for number in range(lines):
        for piece in (f"<piece {name} ", f"{number}", ">\n"):
            os.write(2, piece.encode())


def main() -> None:
    name, lines = sys.argv[1], int(sys.argv[2])
    rclpy.init()
    node = Node(name)
    thread = threading.Thread(target=write_pieces, args=(name, lines))
    thread.start()
    for number in range(lines):
        print(f"<print {name} {number} {'x' * (number * 997 % 9000)}>", end="")
        print(flush=True)
        node.get_logger().info(f"<log {name} {number}>")
        print(f"<error {name} {number}>", file=sys.stderr)
    thread.join()
    node.destroy_node()
    rclpy.try_shutdown()
    print(f"last of {name}")


main()
