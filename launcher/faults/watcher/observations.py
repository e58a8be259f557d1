"""Observations of a run that goes on: those since the last look are taken, and forgotten."""

from __future__ import annotations

import time

from launcher.smoke.observe.fact_recorder import FactRecorder


class Observations(FactRecorder):
    """Times of the day are those of now, whatever the clock showed at the start of the run."""

    def of_wall(self, wall_s: float) -> float:
        """Time of the run; it is right for what has happened since the clock was last set.

        If the clock was set back since, it would be in the future.
        """
        return self.now_s - max(0.0, time.time() - wall_s)

    def wall_of(self, at_s: float) -> float:
        return time.time() - (self.now_s - at_s)
