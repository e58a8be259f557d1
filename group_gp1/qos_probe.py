"""The QoS probe: a subscriber that is wrong on purpose, to see what a mismatch looks like.

The robots publish `/fleet/status` BEST_EFFORT; the probe asks for RELIABLE. A subscription may
ask for less than is offered, never for more, so DDS connects the two not at all: no error, no
message, and in a plain listing of topics all looks well.

How to diagnose it, here and in any other system where a subscriber stays silent:

* `ros2 topic info /fleet/status -v` (or, without an installation of ROS 2,
  `python -m launcher topic info /fleet/status -v`) lists every endpoint with its QoS. Publisher
  and subscription are both there; compare their `Reliability:` and `Durability:` lines. The
  robots say BEST_EFFORT, the probe says RELIABLE: that is the mismatch.
* Both sides log it once per partner, when they discover each other: the probe through the
  incompatible-QoS event below, the robots through rclpy's own handler of the same event
  (`New subscription discovered on topic '/fleet/status', requesting incompatible QoS`).
* The cure is to subscribe with the profile of the publisher, `group_gp1.qos.STATUS`.
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
    """Subscribes to `/fleet/status` with RELIABLE, hears nothing, and says why."""

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
        pass  # the usual end; the node is destroyed already
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
