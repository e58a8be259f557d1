"""The monotonic clock of a host on ours."""

from __future__ import annotations

# Later beats would change the offset while processes live, whose times would not fit together.
_BEATS = 5


class HostClock:
    """The offset is from the beats that came fastest, of the first few."""

    def __init__(self) -> None:
        self._offset_s: float | None = None
        self._beats = 0

    def heard(self, host_s: float, now: float) -> None:
        """The host has said its time, and it has just come."""
        if self._offset_s is None:
            self._offset_s = now - host_s
        elif self._beats < _BEATS:
            self._offset_s = min(self._offset_s, now - host_s)
        self._beats += 1

    def there(self, now: float) -> float:
        """Our time on the clock of the host."""
        return now if self._offset_s is None else now - self._offset_s

    def here(self, host_s: float, now: float) -> float:
        """A time of the host on our clock, not later than now."""
        return now if self._offset_s is None else min(now, host_s + self._offset_s)
