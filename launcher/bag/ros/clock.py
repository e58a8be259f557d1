"""The time of a bag while it is played."""

from __future__ import annotations

MIN_RATE, MAX_RATE = 0.01, 1000.0


class PlayClock:
    """Bag time (ns) as a function of a monotonic time (s): it runs at a rate, pauses and jumps."""

    def __init__(self, bag_ns: int, now_s: float, *, rate: float = 1.0, paused: bool = False):
        self.rate = rate
        self.paused = paused
        self._bag_ns = bag_ns
        self._since_s = now_s

    def time_ns(self, now_s: float) -> int:
        if self.paused:
            return self._bag_ns
        return self._bag_ns + round((now_s - self._since_s) * self.rate * 1e9)

    def wait_s(self, bag_ns: int, now_s: float) -> float:
        """How long until this time of the bag; infinite while paused, negative in the past."""
        if self.paused and bag_ns > self._bag_ns:
            return float("inf")
        return (bag_ns - self.time_ns(now_s)) / 1e9 / self.rate

    def jump(self, bag_ns: int, now_s: float) -> None:
        self._bag_ns, self._since_s = bag_ns, now_s

    def set_rate(self, rate: float, now_s: float) -> None:
        self.jump(self.time_ns(now_s), now_s)
        self.rate = min(max(rate, MIN_RATE), MAX_RATE)

    def set_paused(self, paused: bool, now_s: float) -> None:
        self.jump(self.time_ns(now_s), now_s)
        self.paused = paused
