"""Programs as users write them, each a main in another style: `python plain_node.py STYLE NAME`."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from std_msgs.msg import String
from std_srvs.srv import Trigger


class Plain(Node):
    def __init__(self, name: str, **options: object) -> None:
        super().__init__(name, **options)
        self.declare_parameter("speed", 1.0)
        self.heard: set[str] = set()
        self._chatter = self.create_publisher(String, "chatter", 10)
        self.create_subscription(String, "chatter", self._hear, 10)
        self.create_service(Trigger, f"~/{name}_trigger", self._answer)
        self.create_timer(0.2, self._talk)

    def _talk(self) -> None:
        self._chatter.publish(String(data=self.get_fully_qualified_name()))

    def _hear(self, message: String) -> None:
        if message.data not in self.heard:
            self.heard.add(message.data)
            speed = self.get_parameter("speed").value
            self.get_logger().info(f"heard {message.data} at {speed}")

    @property
    def has_company(self) -> bool:
        """Whether another node was heard, which spins then."""
        return not self.heard <= {self.get_fully_qualified_name()}

    def _answer(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        return response


def usual(name: str) -> None:
    rclpy.init()
    node = Plain(name)
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


def careful(name: str) -> None:
    rclpy.init(args=sys.argv)
    node = Plain(name)
    try:
        rclpy.spin(node)  # returns without an exception, if it is stopped in a callback
        print(f"{name} was stopped")
    except (KeyboardInterrupt, ExternalShutdownException):
        print(f"{name} was stopped")
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def threads(name: str) -> None:
    """Several threads, and one that only prints."""
    rclpy.init()
    node = Plain(name)
    threading.Thread(target=lambda: print(f"{name} has a thread"), daemon=True).start()
    executor = MultiThreadedExecutor(4)
    executor.add_node(node)
    try:
        executor.spin()
    except KeyboardInterrupt:
        print(f"{name} was stopped")
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


def loop(name: str) -> None:
    """Without spin: it looks at `ok()`, has its own handler, and an exit code."""
    signal.signal(signal.SIGTERM, lambda *_: print(f"{name} got SIGTERM"))
    rclpy.init()
    node = Plain(name)
    with contextlib.suppress(ExternalShutdownException):  # only if it waits when it is stopped
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.05)
    sys.exit(f"{name} is not ok any more")


def in_background(node: Node) -> threading.Thread:
    """Spin it there until `rclpy.shutdown()` of another thread, at which rclpy may fail."""

    def spin() -> None:
        with contextlib.suppress(Exception):
            rclpy.spin(node)

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    return thread


def client(name: str) -> None:
    """Calls its own service, from a second node in another context, then ends."""
    context = Context()
    rclpy.init(context=context)
    rclpy.init()
    node = Plain(name)
    other = rclpy.create_node(f"{name}_other", context=context)
    other.get_logger().info("has another context")
    caller = other.create_client(Trigger, f"/{name}/{name}_trigger")
    server = in_background(node)
    assert caller.wait_for_service(20.0)
    future = caller.call_async(Trigger.Request())
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(other)
    executor.spin_until_future_complete(future, 20.0)
    print(f"{name} got {future.result().success}")
    rclpy.shutdown(context=context)
    rclpy.shutdown()
    server.join()


def rate(name: str) -> None:
    rclpy.init()
    node = Plain(name)
    in_background(node)
    ticks = node.create_rate(20)
    for _ in range(5):
        ticks.sleep()
    print(f"{name} has slept")
    rclpy.shutdown()


def fails(name: str) -> None:
    """As soon as another node spins."""
    rclpy.init()
    node = Plain(name)
    node.create_timer(0.1, lambda: [][1] if node.has_company else None)
    rclpy.spin(node)


def exits(name: str) -> None:
    """As soon as another node spins."""
    rclpy.init()
    node = Plain(name)
    while not node.has_company:
        rclpy.spin_once(node)
    sys.exit(3)


def words(name: str) -> None:
    """Ends at once, and prints what it was given."""
    print("words", *remove_ros_args(sys.argv)[1:], end="")
    print(" and", len(sys.argv), file=sys.stdout)
    print("to stderr", file=sys.stderr)


if __name__ == "__main__":
    globals()[sys.argv[1]](sys.argv[2])
