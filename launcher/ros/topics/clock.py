"""The clock of a verb: that of the machine, or with --use-sim-time the one on /clock."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from launcher.ros.messages.decoding import decoder
from launcher.ros.messages.interfaces import load_message
from launcher.ros.topics.raw import subscribed
from launcher.ros.verb import warn

if TYPE_CHECKING:
    from rclpy.subscription import Subscription

    from launcher.ros.discovery.observer import Observer
    from launcher.ros.topics.listener import ReceivedMessage

_NANOS = 1_000_000_000
_PERIOD_S = 0.002
_SILENT_S = 3.0


class WallClock:
    def start(self, observer: Observer) -> None:
        """Begin to follow the time."""

    def stop(self) -> None:
        """Keep the time that it is now, if it cannot be followed without the observer."""

    def now_ns(self) -> int | None:
        """The time of day; None if it is not known yet."""
        return time.time_ns()

    def received_ns(self, sample: ReceivedMessage) -> int | None:
        """When a message that has just been taken arrived."""
        return sample.received_ns

    def elapsed_s(self) -> float:
        """A time to measure intervals with, which does not go back."""
        return time.monotonic()

    def sleep_until(self, elapsed_s: float) -> None:
        time.sleep(max(0.0, elapsed_s - time.monotonic()))


class SimClock(WallClock):
    """Simulation time. It may go back, when a simulation starts again."""

    def __init__(self) -> None:
        self._now_ns: int | None = None
        self._elapsed_ns = 0
        self._subscription: Subscription | None = None
        self._started_s = 0.0
        self._has_warned = False

    def start(self, observer: Observer) -> None:
        from rclpy.qos import QoSProfile, ReliabilityPolicy

        profile = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._started_s = time.monotonic()
        kind = load_message("rosgraph_msgs/msg/Clock")
        self._decode = decoder(kind)
        self._subscription = subscribed(observer.node, kind, "/clock", profile)

    def stop(self) -> None:
        self.now_ns()
        self._subscription = None

    def now_ns(self) -> int | None:
        if self._subscription is None:
            return self._now_ns
        take, kind = self._subscription.handle.take_message, self._subscription.msg_type
        with self._subscription.handle:
            while (taken := take(kind, True)) is not None:
                self._set(self._decode(taken[0]).clock)
        if self._now_ns is None and not self._has_warned:
            self._warn_of_silence()
        return self._now_ns

    def _set(self, stamp: Any) -> None:
        now_ns = int(stamp.sec) * _NANOS + int(stamp.nanosec)
        self._elapsed_ns += max(0, now_ns - self._now_ns) if self._now_ns is not None else 0
        self._now_ns = now_ns

    def _warn_of_silence(self) -> None:
        if time.monotonic() - self._started_s > _SILENT_S:
            self._has_warned = True
            warn(f"no time on /clock for {_SILENT_S:g} s, which --use-sim-time waits for")

    def received_ns(self, sample: ReceivedMessage) -> int | None:
        return self.now_ns()

    def elapsed_s(self) -> float:
        self.now_ns()
        return self._elapsed_ns / _NANOS

    def sleep_until(self, elapsed_s: float) -> None:
        while self.elapsed_s() < elapsed_s or self._now_ns is None:
            time.sleep(_PERIOD_S)


def clock_of(*, simulated: bool) -> WallClock:
    return SimClock() if simulated else WallClock()
