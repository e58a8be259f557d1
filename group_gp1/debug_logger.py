"""The debug logger: logs every message of the fleet."""

from __future__ import annotations

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String

from group_gp1 import qos, runner, topics
from group_gp1.messages import one_line


class DebugLogger(Node):
    """Logs each payload on `/fleet/tasks` and `/fleet/status` unchanged."""

    def __init__(self) -> None:
        super().__init__("debug_logger")
        self._tasks = self.create_subscription(
            String, topics.TASKS, lambda message: self._show(topics.TASKS, message), qos.TASKS
        )
        self._statuses = self.create_subscription(
            String, topics.STATUS, lambda message: self._show(topics.STATUS, message), qos.STATUS
        )

    def _show(self, topic: str, message: String) -> None:
        self.get_logger().info(f"{topic}: {one_line(message.data)}")


def main(args: list[str] | None = None) -> None:
    """Run the debug logger until SIGINT or SIGTERM."""
    try:
        runner.run(DebugLogger, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
