"""`python -m tests.support.many_topics NAME COUNT [raw]`: topics below /NAME, once a second.

With `raw` the messages are bytes that are no text.

Prints `ready` and runs until its stdin is closed.
"""

from __future__ import annotations

import sys
import threading
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import String


def main() -> None:
    rclpy.init()
    name, count = sys.argv[1], int(sys.argv[2])
    node = Node(name)
    publishers = [node.create_publisher(String, f"/{name}/t{n}", 5) for n in range(count)]
    message = b"\0\1\0\0\xff\xff\xff\x7fab" if sys.argv[3:] else String(data="x" * 100)
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    print("ready", flush=True)
    due_s = time.monotonic()
    while True:
        for publisher in publishers:
            publisher.publish(message)
            due_s += 1 / count
            if ended.wait(max(0.0, due_s - time.monotonic())):
                node.destroy_node()
                return


if __name__ == "__main__":
    main()
