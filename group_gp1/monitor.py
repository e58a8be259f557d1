"""monitor: counts completed tasks and warns about silent robots."""

from __future__ import annotations

from group_gp1 import runner
from group_gp1.nodes.monitor_node import Monitor
import rclpy
from rclpy.executors import Executor, ExternalShutdownException, MultiThreadedExecutor

THREADS = 3  # one for each callback of the node, whatever the number of cores


def _make_executor() -> Executor:
    return MultiThreadedExecutor(num_threads=THREADS)


def main(args: list[str] | None = None) -> None:
    """Run the monitor until SIGINT or SIGTERM."""
    try:
        runner.run(Monitor, args, make_executor=_make_executor)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
