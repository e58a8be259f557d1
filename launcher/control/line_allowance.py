"""How many lines a second a client of `logs` is sent: splitting a flood into lines is expensive."""

from __future__ import annotations

from collections import defaultdict

BURST_S = 4.0  # what a process may have saved up: the start of a program is seldom a flood
_DEBT_S = 1.0  # after a large block, the lines that follow are left out for so long


class LineAllowance:
    """A token bucket for each process: `rate` lines a second.

    A block of lines is sent as long as anything is left, and may overdraw it. `has_left_out`:
    something was left out since the last report.
    """

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._left: dict[str, float] = defaultdict(lambda: rate * BURST_S)
        self._since: dict[str, float] = {}
        self._left_out: dict[str, int] = {}

    @property
    def has_left_out(self) -> bool:
        return bool(self._left_out)

    def take(self, process: str, lines: int, now_s: float) -> bool:
        """Whether this many lines of a process may be sent now; those that may not are counted."""
        left = self._left[process] + (now_s - self._since.get(process, now_s)) * self._rate
        self._since[process] = now_s
        self._left[process] = left = min(left, self._rate * BURST_S)
        if left <= 0:
            self._left_out[process] = self._left_out.get(process, 0) + lines
            return False
        self._left[process] = max(left - lines, -self._rate * _DEBT_S)
        return True

    def left_out(self) -> dict[str, int]:
        """Lines of each process that were left out since the last call."""
        found, self._left_out = self._left_out, {}
        return found
