"""Whether to use what systemd shows of a unit if it contradicts the journal."""

from __future__ import annotations

from collections.abc import Callable

SUSPICIOUS = 2  # looks at the unit that contradict the journal, before the journal is awaited


class Doubt:
    """Of one unit. `mark` calls back when all that the journal has now has come.

    The record of an exit may be behind much output in the journal, while systemd has forgotten the
    unit and its exit code.
    """

    def __init__(self, mark: Callable[[Callable[[], None]], None]) -> None:
        self._mark = mark
        self._looks = 0
        self._awaited: object = None
        self._has_come = False

    def clear(self) -> None:
        """A look agrees with the journal."""
        self._looks, self._awaited, self._has_come = 0, None, False

    def is_settled(self) -> bool:
        """One more look contradicts; whether it did before, and the journal has come up to then."""
        self._looks += 1
        if self._looks == SUSPICIOUS:
            awaited = self._awaited = object()
            self._mark(lambda: self._came(awaited))
        return self._has_come

    def _came(self, awaited: object) -> None:
        self._has_come = self._has_come or awaited is self._awaited
