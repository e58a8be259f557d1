"""A node for the smoke tests: `python -m tests.smoke.process.talking_node NAME`.

Publishes a steady and a drifting topic, counts in JSON, answers a service, has a parameter.
"""

from __future__ import annotations

import contextlib
import json
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int32, String
from std_srvs.srv import SetBool

STEADY_S = 0.2  # so long that a busy machine does not make a timer skip a period
DRIFT = 1.06  # of each period: six percent too long
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


class Talking(Node):
    """Has one of everything that expectations can check."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._count = 0
        self._switched: bool | None = None
        self._steady = self.create_publisher(String, "steady", 10)
        self._drifting = self.create_publisher(Int32, "drifting", BEST_EFFORT)
        self.declare_parameter("speed", 1.5)
        self.create_service(SetBool, "switch", self._switch)
        self.create_subscription(String, "orders", self._hear, 10)
        self.create_subscription(Int32, "drifting", lambda _: None, 10)  # RELIABLE: gets nothing
        self.create_timer(STEADY_S, self._talk)
        self.create_timer(STEADY_S * DRIFT, lambda: self._drifting.publish(Int32(data=1)))
        self.get_logger().info("talking")

    def _talk(self) -> None:
        self._count += 1
        content = {"count": self._count, "switched": self._switched, "speed": self._speed()}
        self._steady.publish(String(data=json.dumps(content)))

    def _speed(self) -> float:
        return float(self.get_parameter("speed").value)

    def _hear(self, message: String) -> None:
        self.get_logger().warning(f"ordered: {message.data}")

    def _switch(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._switched = request.data
        response.success = request.data
        return response


def main() -> None:
    """Spin until interrupted."""
    rclpy.init()
    node = Talking(sys.argv[1])
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
