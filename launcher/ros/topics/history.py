"""Which messages of a TRANSIENT_LOCAL topic are its history. Does not import rclpy.

A publisher sends its history to a new subscription in one burst, which says nothing about the rate.
"""

from __future__ import annotations

# A publisher that was there before us has been discovered by then.
_LATEST_NS = 10_000_000_000


class History:
    """Judges the messages of one subscription, in the order of their arrival.

    Messages that were sent before the subscription existed are history. Where the clock of the
    sender, on another host, is off, the rhythm tells: live messages arrive as they were sent.
    """

    def __init__(self, subscribed_ns: int) -> None:
        self._subscribed_ns = subscribed_ns
        self._sent_ns: int | None = None
        self._received_ns = 0

    def has(self, sent_ns: int, received_ns: int) -> bool:
        """Whether this message is history; times of the wall clock."""
        is_in_rhythm = self._is_in_rhythm(sent_ns, received_ns)
        self._sent_ns, self._received_ns = sent_ns, received_ns
        if received_ns - self._subscribed_ns > _LATEST_NS:
            return False
        is_old = sent_ns < self._subscribed_ns or sent_ns > received_ns
        return is_old and not is_in_rhythm

    def _is_in_rhythm(self, sent_ns: int, received_ns: int) -> bool:
        if self._sent_ns is None or sent_ns <= self._sent_ns:
            return False
        interval_ns = sent_ns - self._sent_ns
        return abs(received_ns - self._received_ns - interval_ns) < interval_ns / 4
