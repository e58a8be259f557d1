"""dispatcher: assigns tasks to the robots in turn."""

from __future__ import annotations

from group_gp1 import runner
from group_gp1.nodes.dispatcher_node import Dispatcher
import rclpy
from rclpy.executors import ExternalShutdownException


def main(args: list[str] | None = None) -> None:
    """Run the dispatcher until SIGINT or SIGTERM."""
    try:
        runner.run(Dispatcher, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
