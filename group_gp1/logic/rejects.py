"""Counts invalid payloads and warns about them at a limited rate."""

from __future__ import annotations

from typing import Any

from group_gp1.logic.messages import MessageError

WARNING_GAP_S = 5.0  # one faulty publisher must not flood the log


class Rejects:
    """The invalid payloads that one node received on one topic."""

    def __init__(self, logger: Any, topic: str) -> None:
        self._logger = logger
        self._topic = topic
        self.count = 0

    def add(self, error: MessageError) -> None:
        """Count one, and log a warning with the count at most every WARNING_GAP_S."""
        self.count += 1
        self._logger.warning(
            f'Dropped a malformed payload on {self._topic} ({self.count} so far): {error}',
            throttle_duration_sec=WARNING_GAP_S,
        )
