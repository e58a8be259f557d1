"""A robot that broadcasts its frames, as programs with tf2's broadcasters do.

`python -m tests.support.robot_frames` prints `ready` and runs until its stdin is closed: map ->
odom -> base move at 50 Hz, base -> laser is static, a quarter turn to the left. It needs tf2_msgs.
"""

from __future__ import annotations

import contextlib
import math
import sys
import threading

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RobotFrames(Node):
    """`base` is 1 m in front of `odom`, which is 2 m in front of `map`."""

    def __init__(self) -> None:
        super().__init__("robot_frames")
        self._moving = self.create_publisher(TFMessage, "/tf", 100)
        self._static = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        laser = self._stamped("base", "laser", 0.5, math.pi / 2)
        self._static.publish(TFMessage(transforms=[laser]))
        self.create_timer(0.02, self._send)

    def _send(self) -> None:
        moving = [self._stamped("map", "odom", 2.0), self._stamped("odom", "base", 1.0)]
        self._moving.publish(TFMessage(transforms=moving))

    def _stamped(self, parent: str, child: str, x: float, yaw: float = 0.0) -> TransformStamped:
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id = parent
        message.header.stamp = self.get_clock().now().to_msg()
        message.transform.translation.x = x
        message.transform.rotation.z = math.sin(yaw / 2)
        message.transform.rotation.w = math.cos(yaw / 2)
        return message


def spin(text: str = "") -> None:
    """Broadcast until ROS is shut down; print the text when it has begun."""
    rclpy.init()
    node = RobotFrames()
    print(text, end="", flush=True)
    with contextlib.suppress(ExternalShutdownException, KeyboardInterrupt):
        rclpy.spin(node)
    node.destroy_node()


def main() -> None:
    """Spin until stdin ends."""
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    spin("ready\n")


if __name__ == "__main__":
    main()
