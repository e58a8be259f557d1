"""A node that gets one thing when a file appears: `python -m tests.support.ready_node KIND FILE`.

Until then it is there without it, but for KIND `node`, which makes the node itself.
"""

from __future__ import annotations

import os
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

LOOK_S = 0.02
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class ReadyNode(LifecycleNode):
    """Named `late` unless it is remapped."""

    def __init__(self, kind: str, file: str) -> None:
        super().__init__("late")
        self._kind = kind
        self._file = file
        if kind == "message":
            self._publisher = self.create_publisher(String, "words", LATCHED)
        self._timer = self.create_timer(LOOK_S, self._look)

    def _look(self) -> None:
        if not os.path.exists(self._file):
            return
        self.destroy_timer(self._timer)
        match self._kind:
            case "publisher":
                self.create_publisher(String, "words", 10)
            case "subscription":
                self.create_subscription(String, "words", lambda _: None, 10)
            case "service":
                self.create_service(Trigger, "trigger", lambda _, answer: answer)
            case "lifecycle":
                self.trigger_configure()
                self.trigger_activate()
            case "message":
                self._publisher.publish(String(data="sent once"))


def main() -> None:
    kind, file = sys.argv[1:3]
    while kind == "node" and not os.path.exists(file):
        time.sleep(LOOK_S)
    rclpy.init()
    node: Node = ReadyNode(kind, file)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
