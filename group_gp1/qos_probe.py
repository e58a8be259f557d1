"""The QoS probe: a subscriber with an incompatible QoS, to show what a mismatch looks like.

The robots publish `/fleet/status` BEST_EFFORT; the probe requests RELIABLE. A subscription may
request less than is offered, but not more, so DDS does not connect the two: no error, no message,
and a plain list of topics looks normal.

How to diagnose it, here and in any other system where a subscriber receives nothing:

* `ros2 topic info /fleet/status -v` (or, without an installation of ROS 2,
  `python -m launcher topic info /fleet/status -v`) lists every endpoint with its QoS. Compare the
  `Reliability:` and `Durability:` lines of publishers and subscription: the robots have
  BEST_EFFORT, the probe has RELIABLE. That is the mismatch.
* Both sides log it once per partner, when they discover each other: the probe through the
  incompatible-QoS event below, the robots through rclpy's own handler of the same event
  (`New subscription discovered on topic '/fleet/status', requesting incompatible QoS`).
* The repair is to subscribe with the profile of the publisher, `group_gp1.qos.STATUS`.
"""

from __future__ import annotations

from typing import Any

import rclpy
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_policy_name_from_kind
from std_msgs.msg import String

from group_gp1 import qos, runner, topics

REPORT_PERIOD_S = 5.0


class QosProbe(Node):
    """Subscribes to `/fleet/status` with RELIABLE, receives nothing, and logs the reason."""

    def __init__(self) -> None:
        super().__init__("qos_probe")
        self._received = 0
        self._mismatches = 0
        self._statuses = self.create_subscription(
            String,
            topics.STATUS,
            self._count,
            qos.RELIABLE_STATUS,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=self._explain),
        )
        self._timer = self.create_timer(REPORT_PERIOD_S, self._report)

    def _count(self, message: String) -> None:
        self._received += 1

    def _explain(self, event: Any) -> None:
        self._mismatches = event.total_count
        policy = qos_policy_name_from_kind(event.last_policy_kind)
        self.get_logger().warn(
            f"Incompatible QoS on {topics.STATUS}: {policy}, {event.total_count} publishers so "
            f"far. To diagnose: ros2 topic info {topics.STATUS} -v"
        )

    def _report(self) -> None:
        self.get_logger().info(
            f"Received {self._received} messages on {topics.STATUS}, "
            f"{self._mismatches} publishers do not match"
        )


def main(args: list[str] | None = None) -> None:
    """Run the probe until SIGINT or SIGTERM."""
    try:
        runner.run(QosProbe, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
