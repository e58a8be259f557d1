"""A node with parameters of many kinds, for forms; `/grow` gives it one more publisher.

`python -m tests.support.parameter_node` prints `ready` and runs until its stdin is closed.
"""

from __future__ import annotations

import contextlib
import sys
import threading

import rclpy
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String
from std_srvs.srv import Trigger

LIMITS = IntegerRange(from_value=1, to_value=9, step=2)
SPEEDS = FloatingPointRange(from_value=0.0, to_value=2.0)


class ParameterNode(Node):
    def __init__(self) -> None:
        super().__init__("tunable")
        self.declare_parameter("gears", 3, ParameterDescriptor(integer_range=[LIMITS]))
        speed = ParameterDescriptor(
            description="in m/s",
            additional_constraints="not 1.5",
            floating_point_range=[SPEEDS],
        )
        self.declare_parameter("speed", 0.5, speed)
        self.declare_parameter("serial", "A7", ParameterDescriptor(read_only=True))
        self.declare_parameter("later", Parameter.Type.INTEGER)
        self.declare_parameter("loose", "abc", ParameterDescriptor(dynamic_typing=True))
        self.declare_parameter("bytes", [b"\x00", b"\xff"])
        self.add_on_set_parameters_callback(_judge)
        self._more = [self.create_publisher(String, "grown", 1)]
        self.create_service(Trigger, "grow", self._grow)

    def _grow(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._more.append(self.create_publisher(String, "grown", 1))
        response.success = True
        return response


def _judge(parameters: list[Parameter]) -> SetParametersResult:
    if any(p.name == "speed" and p.value == 1.5 for p in parameters):
        return SetParametersResult(successful=False, reason="1.5 m/s makes it resonate")
    return SetParametersResult(successful=True)


def main() -> None:
    rclpy.init()
    node = ParameterNode()
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):
        rclpy.spin(node)
    node.destroy_node()


if __name__ == "__main__":
    main()
