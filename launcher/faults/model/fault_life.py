"""The life of a fault: a suspicion that is confirmed, and that heals; time is an argument."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class FaultState(enum.Enum):
    """Of a fault that was seen at least once."""

    SUSPECTED = "suspected"
    ACTIVE = "active"  # it was confirmed, and is not healed
    HEALED = "healed"


class FaultChange(enum.Enum):
    """What a look has changed."""

    SUSPECTED = "suspected"
    CONFIRMED = "confirmed"
    DISMISSED = "dismissed"  # a suspicion that was none
    HEALED = "healed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Debounce:
    """A fault is confirmed after `confirm_s` without a break, or after `times` violations.

    It is healed when nothing was violated for `heal_s`. Times are in seconds.
    """

    confirm_s: float = 1.0
    times: int | None = None
    heal_s: float = 3.0


class FaultLife:
    """One fault, from the first time that it was seen; `state` None: dismissed.

    `first_s` is since when it does not hold, `suspected_s` when that was noticed.
    """

    def __init__(self, debounce: Debounce) -> None:
        self.debounce = debounce
        self.state: FaultState | None = None
        self.first_s = self.suspected_s = self.last_s = 0.0
        self.confirmed_s: float | None = None
        self.healed_s: float | None = None
        self.count = 0  # how often it was confirmed
        self._seen = 0  # violations since `first_s`
        # `first_s`, `confirmed_s`, `last_s` and `healed_s` of the last time, while it is suspected.
        self._before: tuple[float, float | None, float, float | None] | None = None

    def violated(
        self, now_s: float, *, since_s: float | None = None, times: int = 1, certain: bool = False
    ) -> FaultChange | None:
        """It does not hold, since `since_s`; `certain`: that needs no confirmation."""
        is_new = self.state in (None, FaultState.HEALED)
        if is_new:
            if self.count:
                self._before = self.first_s, self.confirmed_s, self.last_s, self.healed_s
            self.first_s = now_s if since_s is None else min(since_s, now_s)
            self._seen = 0
            self.suspected_s = now_s
            self.state, self.confirmed_s, self.healed_s = FaultState.SUSPECTED, None, None
        self.last_s = now_s
        self._seen += times
        if self.state is FaultState.SUSPECTED and (certain or self._is_confirmed(now_s)):
            self.state, self.confirmed_s = FaultState.ACTIVE, now_s
            self.count += 1
            return FaultChange.CONFIRMED
        return FaultChange.SUSPECTED if is_new else None

    def resume(
        self,
        state: FaultState,
        count: int,
        times_s: tuple[float, float | None, float, float | None],
    ) -> None:
        """Go on as another watcher has left it; `first_s`, `confirmed_s`, `last_s`, `healed_s`."""
        self.state, self.count = state, count
        self.first_s, self.confirmed_s, self.last_s, self.healed_s = times_s

    def _is_confirmed(self, now_s: float) -> bool:
        if self.debounce.times is not None:
            return self._seen >= self.debounce.times
        return now_s - self.first_s >= self.debounce.confirm_s

    def held(self, now_s: float) -> FaultChange | None:
        """It holds; what was only suspected is again as it was before."""
        if self.state is FaultState.SUSPECTED:
            if self._before is None:
                self.state = None
            else:
                self.state = FaultState.HEALED
                self.first_s, self.confirmed_s, self.last_s, self.healed_s = self._before
            return FaultChange.DISMISSED
        if self.state is FaultState.ACTIVE and now_s - self.last_s >= self.debounce.heal_s:
            self.state, self.healed_s = FaultState.HEALED, now_s
            return FaultChange.HEALED
        return None
