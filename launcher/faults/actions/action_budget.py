"""How often something may be done."""

from __future__ import annotations

from collections import deque


class ActionBudget:
    """At most `times` in `period_s`; the times of calls do not go back."""

    def __init__(self, times: int, period_s: float) -> None:
        self._period_s = period_s
        self._taken: deque[float] = deque(maxlen=times)
        self._refused = 0

    def take(self, now_s: float) -> bool:
        """Whether it may be done now, which is then counted."""
        is_full = len(self._taken) == self._taken.maxlen
        if is_full and now_s - self._taken[0] < self._period_s:
            self._refused += 1
            return False
        self._taken.append(now_s)
        self._refused = 0
        return True

    @property
    def is_first_refusal(self) -> bool:
        """Whether the last call was the first that was refused: the others need no warning."""
        return self._refused == 1
