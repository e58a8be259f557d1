"""Unusable payloads: counted, warned about now and then, dropped."""

from __future__ import annotations

from typing import Any

from group_gp1.messages import MessageError

WARNING_GAP_S = 5.0  # one broken publisher must not drown the log


class Rejects:
    """The unusable payloads that one node got on one topic."""

    def __init__(self, logger: Any, topic: str) -> None:
        self._logger = logger
        self._topic = topic
        self.count = 0

    def add(self, error: MessageError) -> None:
        """Count one; a warning at most every WARNING_GAP_S carries the count."""
        self.count += 1
        self._logger.warning(
            f"Dropped a malformed payload on {self._topic} ({self.count} so far): {error}",
            throttle_duration_sec=WARNING_GAP_S,
        )
