"""Observations of a run that goes on: those since the last look are taken, and forgotten."""

from __future__ import annotations

import time

from launcher.smoke.observe.fact_recorder import FactRecorder

SET_S = 0.005  # the two clocks drift apart by less between two looks at them


class Observations(FactRecorder):
    """Times of the day are those of now, whatever the clock showed at the start of the run."""

    _offset_s = 0.0

    def of_wall(self, wall_s: float) -> float:
        """Time of the run; it is right for what has happened since the clock was last set.

        If the clock was set back since, it would be in the future. Of two times the earlier one
        stays it.
        """
        return min(self.now_s, self.of_monotonic(wall_s - self._offset()))

    def wall_of(self, at_s: float) -> float:
        return at_s - self.of_monotonic(0.0) + self._offset()

    def _offset(self) -> float:
        """The time of the day minus the monotonic clock; the same until the clock is set."""
        offset_s = time.time() - time.monotonic()
        if abs(offset_s - self._offset_s) > SET_S:
            self._offset_s = offset_s
        return self._offset_s
