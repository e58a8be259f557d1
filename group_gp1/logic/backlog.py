"""The backlog of a late joiner: assignments sent before it was connected to the dispatcher."""

from __future__ import annotations

from group_gp1.logic.messages import TaskAssignment

MIN_AGE_NS = 50_000_000  # a new message takes a millisecond, on a busy machine more
_NS_PER_S = 1e9


class Backlog:
    """
    Distinguishes kept assignments from new ones and counts them, until the first new one.

    DDS delivers what TRANSIENT_LOCAL kept at once when it connects the two sides. So the arrival
    of the first assignment, if that one is old, is the time of the connection, and the backlog is
    what was sent before. All times are wall-clock nanoseconds, stamped by DDS at sender and
    receiver: correct on one host, or on hosts with synchronised clocks.
    """

    def __init__(self, robot_id: str) -> None:
        self._robot_id = robot_id
        self._connected_ns: int | None = None
        self._open = True
        self.received = 0
        self.mine = 0

    def note(self, assignment: TaskAssignment, *, sent_ns: int, received_ns: int) -> str | None:
        """Record a received assignment; returns a line for the log, or None."""
        if not self._open:
            return None
        if self._connected_ns is None:
            late = received_ns - sent_ns >= MIN_AGE_NS
            self._connected_ns = received_ns if late else sent_ns
        if sent_ns >= self._connected_ns:
            self._open = False
            return self._summary() if self.received else None
        return self._count(assignment, age_s=(self._connected_ns - sent_ns) / _NS_PER_S)

    def _count(self, assignment: TaskAssignment, *, age_s: float) -> str:
        self.received += 1
        self.mine += assignment.robot_id == self._robot_id
        return (
            f'Backlog {self.received}: {assignment.task} for {assignment.robot_id}, '
            f'assigned {age_s:.1f} s before {self._robot_id} was connected'
        )

    def _summary(self) -> str:
        return (
            f'Late joiner: received {self.received} assignments from before '
            f'{self._robot_id} was connected, {self.mine} of them addressed to it'
        )
