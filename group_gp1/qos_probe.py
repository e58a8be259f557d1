"""qos_probe: subscribes with an incompatible QoS, to show what a mismatch looks like."""

from __future__ import annotations

from group_gp1 import runner
from group_gp1.nodes.qos_probe_node import QosProbe
import rclpy
from rclpy.executors import ExternalShutdownException


def main(args: list[str] | None = None) -> None:
    """Run the probe until SIGINT or SIGTERM."""
    try:
        runner.run(QosProbe, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
