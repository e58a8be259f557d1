"""Whether the journal is behind with the output of a process."""

from __future__ import annotations

# Bytes: of a process that has written more, the journal may have a piece before the record of its
# exit and the rest behind it. It reads about 48 KB of a stream at a time.
MUCH = 16 * 1024


class RecentOutput:
    """Whether the journal may have more of a process that has exited."""

    def __init__(self) -> None:
        self._bytes = 0  # since the last exit
        self._has_more = False

    def add(self, size: int) -> None:
        self._bytes += size
        self._has_more = True

    def ended(self) -> None:
        self._has_more = self._bytes > MUCH
        self._bytes = 0

    def looked(self) -> None:
        self._has_more = False

    @property
    def may_be_behind(self) -> bool:
        """Whether much has come before the exit, or something since it, or since `looked`."""
        return self._has_more
