"""Which changes are over: a file is written in several steps, and a checkout writes many files."""

from __future__ import annotations

from collections.abc import Iterable

QUIET_S = 0.2  # without another change
LONGEST_S = 2.0  # after the first change; then files that are quiet themselves do not wait any more


class Settling:
    """Changes that are not over yet. Times are those of one clock, in seconds."""

    def __init__(self) -> None:
        self._last: dict[str, float] = {}
        self._first_s = 0.0

    def note(self, paths: Iterable[str], now: float) -> None:
        """These have changed."""
        for path in paths:
            if not self._last:
                self._first_s = now
            self._last[path] = now

    @property
    def busy(self) -> list[str]:
        """What is not over."""
        return list(self._last)

    @property
    def due_s(self) -> float | None:
        """When `take` may have something; None if nothing has changed."""
        if not self._last:
            return None
        all_are = max(self._last.values()) + QUIET_S
        one_is = min(self._last.values()) + QUIET_S
        return min(all_are, max(one_is, self._first_s + LONGEST_S))

    def take(self, now: float) -> list[str]:
        """What is over: everything, unless that takes too long."""
        due_s = self.due_s
        if due_s is None or now < due_s:
            return []
        over = [path for path, changed_s in self._last.items() if now >= changed_s + QUIET_S]
        for path in over:
            del self._last[path]
        self._first_s = now
        return over
