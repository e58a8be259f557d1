"""The debug logger: writes every message of the fleet into the log."""

from __future__ import annotations

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String

from group_gp1 import qos, runner, topics

MAX_SHOWN_CHARS = 300  # longer than any payload of the fleet itself


class DebugLogger(Node):
    """Reads `/fleet/tasks` and `/fleet/status` and logs each payload as it is."""

    def __init__(self) -> None:
        super().__init__("debug_logger")
        self._tasks = self.create_subscription(
            String, topics.TASKS, lambda message: self._show(topics.TASKS, message), qos.TASKS
        )
        self._statuses = self.create_subscription(
            String, topics.STATUS, lambda message: self._show(topics.STATUS, message), qos.STATUS
        )

    def _show(self, topic: str, message: String) -> None:
        self.get_logger().info(f"{topic}: {shown(message.data)}")


def shown(payload: str) -> str:
    """The payload on one line of bounded length; a well-formed one is unchanged."""
    line = payload if payload.isprintable() else repr(payload)
    if len(line) <= MAX_SHOWN_CHARS:
        return line
    return f"{line[:MAX_SHOWN_CHARS]}... ({len(payload)} characters)"


def main(args: list[str] | None = None) -> None:
    """Run the debug logger until SIGINT or SIGTERM."""
    try:
        runner.run(DebugLogger, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual end; the node is destroyed already
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
