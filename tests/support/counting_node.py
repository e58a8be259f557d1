"""A node for tests of the page: a counter, parameters that refuse, a service, hostile texts."""

from __future__ import annotations

import contextlib
import json
import math

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Float32, Int32, String
from std_srvs.srv import SetBool

HOSTILE = (
    "<img src=x onerror=\"alert('x')\"><script>alert(1)</script>&lt;b&gt;"
    "{{7919*6271}}${7919*6271}\u202eabc"
)
EVALUATED = "49660049"  # what a template would make of it
REFUSAL = "robots do not <b>run</b>"


class Counter(Node):
    def __init__(self) -> None:
        super().__init__("counter")
        self.count = 0
        self._counts = self.create_publisher(Int32, "counts", 10)
        self._gaps = self.create_publisher(Float32, "gaps", 10)
        self._texts = self.create_publisher(String, "texts", 10)
        speed = ParameterDescriptor(
            description="metres per second",
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=2.0, step=0.0)],
        )
        self.declare_parameter("speed", 0.5, speed)
        self.declare_parameter("mode", "walk", ParameterDescriptor(description=HOSTILE))
        self.declare_parameter("serial", HOSTILE, ParameterDescriptor(read_only=True))
        self.add_on_set_parameters_callback(self._check)
        self.create_service(SetBool, "reset", self._reset)
        self.create_timer(0.1, self._tick)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        refused = any(one.name == "mode" and one.value == "run" for one in parameters)
        return SetParametersResult(successful=not refused, reason=REFUSAL if refused else "")

    def _reset(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = request.data
        response.message = f"was {self.count}"
        self.count = 0
        return response

    def _tick(self) -> None:
        self.count += 1
        self._counts.publish(Int32(data=self.count))
        self._gaps.publish(Float32(data=self.count / 2 if self.count % 20 < 10 else math.nan))
        text = json.dumps({"count": self.count, "text": HOSTILE})
        self._texts.publish(String(data=text if self.count % 2 else HOSTILE))
        if self.count % 10 == 0:
            self.get_logger().info(f"{HOSTILE} {self.count}")
            self.get_logger().error(f"\x1b[31;1mred {HOSTILE}\x1b[0m")


def main() -> None:
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Counter())


if __name__ == "__main__":
    main()
