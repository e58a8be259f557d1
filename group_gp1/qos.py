"""The quality of service of each topic, as explicit profiles with the reason for every choice.

Publisher and subscriptions of a topic take the same profile; the one exception is
`RELIABLE_STATUS`, which is wrong on purpose.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

TASKS_DEPTH = 5
STATUS_DEPTH = 3
REPORT_DEPTH = 10
MAX_DEPTH = 1000  # Fast DDS keeps every sample in memory; a larger queue hides a problem


def tasks_profile(depth: int = TASKS_DEPTH) -> QoSProfile:
    """The profile of `/fleet/tasks`; other depths are for the queue overflow experiment."""
    return QoSProfile(
        # an assignment is an order: one lost on the wire would never be carried out
        reliability=ReliabilityPolicy.RELIABLE,
        # robot_3 joins late and still gets the last assignments
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        # a robot that falls behind works on recent orders; depth 5 is about two rounds of three
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
    )


TASKS = tasks_profile()

STATUS = QoSProfile(
    # repeated every second: the next one replaces a lost one, so waiting for repair is waste
    reliability=ReliabilityPolicy.BEST_EFFORT,
    # yesterday's status would be taken for a sign of life
    durability=DurabilityPolicy.VOLATILE,
    # room for one status of each of the three robots between two looks
    history=HistoryPolicy.KEEP_LAST,
    depth=STATUS_DEPTH,
)

REPORT = QoSProfile(
    # one line every two seconds, read by people: none should be missing
    reliability=ReliabilityPolicy.RELIABLE,
    # a reader who comes later waits two seconds for a fresh report
    durability=DurabilityPolicy.VOLATILE,
    # twenty seconds of reports for a reader that was busy
    history=HistoryPolicy.KEEP_LAST,
    depth=REPORT_DEPTH,
)

# Asks for more than the robots offer on /fleet/status, so DDS connects it to none of them.
RELIABLE_STATUS = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=STATUS_DEPTH,
)
