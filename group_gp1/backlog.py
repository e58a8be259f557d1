"""The backlog of a late joiner: assignments that were published before it subscribed."""

from __future__ import annotations

from group_gp1.messages import TaskAssignment

_NS_PER_S = 1e9


class Backlog:
    """Tells old assignments from fresh ones and counts the old, until the first fresh one.

    What was sent before `subscribed_ns` can only come from the history that TRANSIENT_LOCAL keeps
    at the publisher. Times are wall-clock nanoseconds as DDS stamps them when it sends, so this
    is right for dispatcher and robot on one host, or on hosts with synchronised clocks.
    """

    def __init__(self, robot_id: str, *, subscribed_ns: int) -> None:
        self._robot_id = robot_id
        self._subscribed_ns = subscribed_ns
        self._open = True
        self.received = 0
        self.mine = 0

    def note(self, assignment: TaskAssignment, *, sent_ns: int) -> str | None:
        """Enter one received assignment; returns a line for the log where there is news."""
        if not self._open:
            return None
        if sent_ns >= self._subscribed_ns:
            self._open = False
            return self._summary() if self.received else None
        self.received += 1
        self.mine += assignment.robot_id == self._robot_id
        age_s = (self._subscribed_ns - sent_ns) / _NS_PER_S
        return (
            f"Backlog {self.received}: {assignment.task} for {assignment.robot_id}, "
            f"assigned {age_s:.1f} s before {self._robot_id} subscribed"
        )

    def _summary(self) -> str:
        return (
            f"Late joiner: received {self.received} assignments that were sent before "
            f"{self._robot_id} subscribed, {self.mine} of them addressed to it"
        )
