"""Which messages of a TRANSIENT_LOCAL topic are its history. Does not import rclpy.

A publisher sends its history to a new subscription in one burst, which says nothing about the rate.
"""

from __future__ import annotations

from dataclasses import dataclass

# A publisher that was there before us has been discovered by then.
_LATEST_NS = 10_000_000_000
# Messages that arrive closer together than this are one burst: a history that was published in a
# burst has the intervals of live messages.
_BURST_NS = 100_000_000


@dataclass(slots=True)
class _Rhythm:
    """Whether the messages of one publisher arrive as they were sent, from burst to burst."""

    sent_ns: int
    received_ns: int
    is_kept: bool = False

    def add(self, sent_ns: int, received_ns: int) -> None:
        arrived_ns = received_ns - self.received_ns
        if arrived_ns < _BURST_NS:
            return
        interval_ns = sent_ns - self.sent_ns
        self.is_kept = abs(arrived_ns - interval_ns) < interval_ns / 4
        self.sent_ns, self.received_ns = sent_ns, received_ns


class TopicHistory:
    """Judges the messages of one subscription, in the order of their arrival.

    Messages that were sent before the subscription existed are history. Where the clock of the
    sender, on another host, is off, the intervals decide: live messages arrive as they were sent.
    """

    def __init__(self, subscribed_ns: int) -> None:
        self._subscribed_ns = subscribed_ns
        self._rhythms: dict[bytes, _Rhythm] = {}

    def has(self, publisher: bytes, sent_ns: int, received_ns: int) -> bool:
        """Whether this message is history: the gid of its publisher, times of the wall clock."""
        if received_ns - self._subscribed_ns > _LATEST_NS:
            return False
        rhythm = self._rhythms.setdefault(publisher, _Rhythm(sent_ns, received_ns))
        rhythm.add(sent_ns, received_ns)
        is_old = sent_ns < self._subscribed_ns or sent_ns > received_ns
        return is_old and not rhythm.is_kept
