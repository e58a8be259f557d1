"""
The QoS probe: a subscriber with an incompatible QoS, to show what a mismatch looks like.

The robots publish `/fleet/status` BEST_EFFORT; the probe requests RELIABLE. A subscription may
request less than is offered, but not more, so DDS does not connect the two: no error, no message,
and a plain list of topics looks normal.

How to diagnose it, here and in any other system where a subscriber receives nothing:

* `ros2 topic info /fleet/status -v` (or, without an installation of ROS 2,
  `python -m launcher topic info /fleet/status -v`) lists every endpoint with its QoS. Compare the
  `Reliability:` and `Durability:` lines of publishers and subscription: the robots have
  BEST_EFFORT, the probe has RELIABLE. That is the mismatch.
* Both sides log it when they discover each other: the probe through the incompatible-QoS event
  below, with the number of publishers, the robots through rclpy's own handler of the same event
  (`New subscription discovered on topic '/fleet/status', requesting incompatible QoS`).
* The repair is to subscribe with the profile of the publisher, `group_gp1.qos.STATUS`.
"""

from __future__ import annotations

from typing import Any

from group_gp1 import qos, topics
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    qos_check_compatible,
    qos_policy_name_from_kind,
    QoSCompatibility,
    QoSProfile,
)
from std_msgs.msg import String

REPORT_PERIOD_S = 5.0
SETTLING_S = 0.5  # publishers that start together are explained together
MOST_LOOKS = 20  # of SETTLING_S, until the names of all nodes are known
UNKNOWN_NODE = '_NODE_NAME_UNKNOWN_'


class QosProbe(Node):
    """Subscribes to `/fleet/status` with RELIABLE, receives nothing, and logs the reason."""

    def __init__(self) -> None:
        super().__init__('qos_probe')
        self._received = 0
        self._statuses = self.create_subscription(
            String,
            topics.STATUS,
            self._count,
            qos.RELIABLE_STATUS,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=self._mismatch),
        )
        self._policy, self._looks = '', 0
        self._explanation = self.create_timer(SETTLING_S, self._explain)
        self._explanation.cancel()  # until there is a mismatch
        self._timer = self.create_timer(REPORT_PERIOD_S, self._report)

    def _count(self, message: String) -> None:
        self._received += 1

    def _mismatch(self, event: Any) -> None:
        self._policy = qos_policy_name_from_kind(event.last_policy_kind)
        self._looks = MOST_LOOKS
        self._explanation.reset()

    def _explain(self) -> None:
        nodes = self._mismatches()
        self._looks -= 1
        if any(name == UNKNOWN_NODE for _, name in nodes) and self._looks:
            return  # it comes soon
        self._explanation.cancel()
        self.get_logger().warn(
            f'Incompatible QoS on {topics.STATUS}: {self._policy}, {len(nodes)} publishers do not '
            f'match. To diagnose: ros2 topic info {topics.STATUS} -v'
        )

    def _mismatches(self) -> set[tuple[str, str]]:
        """
        Return the nodes whose publishers do not match now; the event counts all that ever were.

        That of a killed robot is listed for 20 s, beside that of its restart.
        """
        return {
            (info.node_namespace, info.node_name)
            for info in self.get_publishers_info_by_topic(topics.STATUS)
            if is_incompatible(info.qos_profile, qos.RELIABLE_STATUS)
        }

    def _report(self) -> None:
        self.get_logger().info(
            f'Received {self._received} messages on {topics.STATUS}, '
            f'{len(self._mismatches())} publishers do not match'
        )


def is_incompatible(offered: QoSProfile, requested: QoSProfile) -> bool:
    """Whether a subscription receives nothing from a publisher."""
    compatibility, _ = qos_check_compatible(offered, requested)
    return bool(compatibility == QoSCompatibility.ERROR)
