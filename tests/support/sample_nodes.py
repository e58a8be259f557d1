"""Nodes for the tests of the ROS verbs, in one process: topics of many kinds, a mismatch, twins.

`python -m tests.support.sample_nodes` prints `ready` and runs until its stdin is closed.
"""

from __future__ import annotations

import contextlib
import sys
import threading

import rclpy
from geometry_msgs.msg import PointStamped
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64MultiArray, Int32, String
from std_srvs.srv import SetBool, Trigger

PERIOD_S = 0.1
IDLE_PERIOD_S = 1.0  # without a reader: the nodes run as long as the tests
OCCUPIED_S = 3.0
LISTENERS = 1  # of this process, to `chatter`

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Talker(Node):
    """Publishes on several topics ten times a second if anybody reads, and answers a service."""

    def __init__(self) -> None:
        super().__init__("talker")
        self._count = 0
        self._texts = self.create_publisher(String, "chatter", 10)
        self._weak = self.create_publisher(String, "weak", BEST_EFFORT)
        self._hidden = self.create_publisher(String, "_secret", 10)
        self._numbers = self.create_publisher(Float64MultiArray, "numbers", 10)
        self._points = self.create_publisher(PointStamped, "points", 10)
        self._latched = self.create_publisher(Int32, "latched", LATCHED)
        for number in range(8):
            self._latched.publish(Int32(data=number))
        self.declare_parameter("speed", 1.5, _speed())
        self.declare_parameter("name", "sample")
        self.declare_parameter("tags", ["a", "b"])
        self.create_service(SetBool, "switch", self._switch)
        self.create_service(Trigger, "occupy", self._occupy)
        self._timer = self.create_timer(PERIOD_S, self._talk)

    def _has_readers(self) -> bool:
        return self._texts.get_subscription_count() > LISTENERS or any(
            publisher.get_subscription_count()
            for publisher in (self._weak, self._hidden, self._numbers, self._points)
        )

    def _talk(self) -> None:
        has_readers = self._has_readers()
        period_ns = int((PERIOD_S if has_readers else IDLE_PERIOD_S) * 1e9)
        if self._timer.timer_period_ns != period_ns:
            self._timer.timer_period_ns = period_ns
            self._timer.reset()  # the next call was due by the old period
        if not has_readers:
            return
        self._count += 1
        self._texts.publish(String(data=f"msg {self._count}"))
        self._weak.publish(String(data="weak"))
        self._numbers.publish(Float64MultiArray(data=[float(n) for n in range(200)]))
        point = PointStamped()
        point.header.stamp = self.get_clock().now().to_msg()
        point.header.frame_id = "map"
        point.point.x = 0.5
        self._points.publish(point)

    def _switch(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = request.data
        response.message = "on" if request.data else "off"
        return response

    def _occupy(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Keep the executor from everything else for a while."""
        threading.Event().wait(OCCUPIED_S)
        return response


def _speed() -> ParameterDescriptor:
    limits = FloatingPointRange(from_value=0.0, to_value=2.0)
    return ParameterDescriptor(description="speed in m/s", floating_point_range=[limits])


class Listener(Node):
    """Asks for RELIABLE on a topic that is offered BEST_EFFORT; lives in a namespace.

    Its parameters need no declaration.
    """

    def __init__(self) -> None:
        super().__init__("listener", namespace="/site/east", allow_undeclared_parameters=True)
        self.declare_parameter("counts", [1, 2, 3])
        self.declare_parameter("ratios", [0.5, 1.0])
        self.declare_parameter("bytes", [b"\x00", b"\xff"])
        self.create_subscription(String, "/weak", lambda _: None, 10)
        self.create_subscription(String, "/chatter", lambda _: None, 10)


def main() -> None:
    """Spin until stdin ends."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    twins = [Node("twin"), Node("twin")]
    nodes = [Talker(), Listener(), Node("_shy"), *twins]
    for node in nodes:
        executor.add_node(node)
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):  # stdin has ended
        executor.spin()
    for node in nodes:
        node.destroy_node()


if __name__ == "__main__":
    main()
