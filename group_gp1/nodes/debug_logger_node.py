"""The debug logger: logs every message of the fleet."""

from __future__ import annotations

from group_gp1 import qos, topics
from group_gp1.logic.messages import one_line
from rclpy.node import Node
from std_msgs.msg import String


class DebugLogger(Node):
    """Logs each payload on `/fleet/tasks` and `/fleet/status` unchanged."""

    def __init__(self) -> None:
        super().__init__('debug_logger')
        self._tasks = self.create_subscription(
            String, topics.TASKS, lambda message: self._show(topics.TASKS, message), qos.TASKS
        )
        self._statuses = self.create_subscription(
            String, topics.STATUS, lambda message: self._show(topics.STATUS, message), qos.STATUS
        )

    def _show(self, topic: str, message: String) -> None:
        self.get_logger().info(f'{topic}: {one_line(message.data)}')
