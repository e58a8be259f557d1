"""Lifecycle nodes in one process, of which some refuse or fail.

`python -m tests.support.lifecycle_nodes` prints `ready` and runs until its stdin is closed.
"""

from __future__ import annotations

import contextlib
import sys
import threading

import rclpy
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node

END = threading.Event()


class Stuck(LifecycleNode):
    """Cannot be activated."""

    def on_activate(self, state: object) -> TransitionCallbackReturn:
        return TransitionCallbackReturn.FAILURE


class Slow(LifecycleNode):
    """Answers nobody while it is configured, which takes until the end."""

    def on_configure(self, state: object) -> TransitionCallbackReturn:
        END.wait()
        return TransitionCallbackReturn.SUCCESS


def wait_for_end() -> None:
    sys.stdin.read()
    END.set()
    rclpy.try_shutdown()


def main() -> None:
    """Spin until stdin ends."""
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    nodes = [
        LifecycleNode("pump"),
        Stuck("stuck", namespace="/site"),
        Slow("slow"),
        LifecycleNode("_hidden"),
        Node("plain"),
    ]
    for node in nodes:
        executor.add_node(node)
    threading.Thread(target=wait_for_end, daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):  # stdin has ended
        executor.spin()
    for node in nodes:
        node.destroy_node()


if __name__ == "__main__":
    main()
