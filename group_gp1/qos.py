"""
The QoS profile of each topic, with the reason for every choice.

Publishers and subscriptions of a topic use the same profile; the exception is `RELIABLE_STATUS`,
which is incompatible on purpose.
"""

from __future__ import annotations

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.qos_overriding_options import QosCallbackResult, QoSOverridingOptions

TASKS_DEPTH = 5
STATUS_DEPTH = 3
REPORT_DEPTH = 10
MAX_DEPTH = 1000  # Fast DDS keeps every sample in memory; a larger queue hides a problem


def _check_depth(profile: QoSProfile) -> QosCallbackResult:
    is_good = 1 <= profile.depth <= MAX_DEPTH
    reason = f'a depth must be from 1 to {MAX_DEPTH}. Found: {profile.depth}'
    return QosCallbackResult(successful=is_good, reason='' if is_good else reason)


# Discovery has no depths: the parameter `qos_overrides./TOPIC.publisher.depth` (`subscription`) of
# a node shows the one of its endpoint, and can override it.
DEPTH_PARAMETER = QoSOverridingOptions((QoSPolicyKind.DEPTH,), callback=_check_depth)


def tasks_profile(depth: int = TASKS_DEPTH) -> QoSProfile:
    """Make the profile of `/fleet/tasks`; other depths are for the queue overflow experiment."""
    return QoSProfile(
        # an assignment lost on the wire would never be executed
        reliability=ReliabilityPolicy.RELIABLE,
        # robot_3 joins late and still gets the last assignments
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        # a slow robot works on recent assignments; depth 5 is about two rounds of three
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
    )


TASKS = tasks_profile()


def status_profile(depth: int = STATUS_DEPTH) -> QoSProfile:
    """Make the profile of `/fleet/status`; other depths are for readers of many robots."""
    return QoSProfile(
        # repeated every second: the next one replaces a lost one, so a repair is not needed
        reliability=ReliabilityPolicy.BEST_EFFORT,
        # an old status would look like a robot that is alive
        durability=DurabilityPolicy.VOLATILE,
        # one status of each of the three robots while the reader is busy
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
    )


STATUS = status_profile()

REPORT = QoSProfile(
    # one line every two seconds, read by people: none should be missing
    reliability=ReliabilityPolicy.RELIABLE,
    # a late reader waits two seconds for a new report
    durability=DurabilityPolicy.VOLATILE,
    # twenty seconds of reports for a reader that was busy
    history=HistoryPolicy.KEEP_LAST,
    depth=REPORT_DEPTH,
)

# Requests more than the robots offer on /fleet/status, so DDS connects it to none of them.
RELIABLE_STATUS = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=STATUS_DEPTH,
)
