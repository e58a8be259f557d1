"""debug_logger: logs every message of the fleet."""

from __future__ import annotations

from group_gp1 import runner
from group_gp1.nodes.debug_logger_node import DebugLogger
import rclpy
from rclpy.executors import ExternalShutdownException


def main(args: list[str] | None = None) -> None:
    """Run the debug logger until SIGINT or SIGTERM."""
    try:
        runner.run(DebugLogger, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
