"""Whether the journal is behind with the output of a process."""

from __future__ import annotations

MUCH = 16 * 1024  # bytes in a second, after which a stream may be behind


class RecentOutput:
    """Whether the journal may have more of a process that has exited."""

    def __init__(self) -> None:
        self._second, self._bytes, self._has_more = 0.0, 0, False

    def add(self, size: int, at_s: float) -> None:
        if at_s - self._second > 1.0:
            self._second, self._bytes = at_s, 0
        self._bytes += size
        self._has_more = True

    def ended(self) -> None:
        self._has_more = self._bytes > MUCH

    def looked(self) -> None:
        self._has_more = False

    @property
    def may_be_behind(self) -> bool:
        """Whether much has come before the exit, or something since it, or since `looked`."""
        return self._has_more
