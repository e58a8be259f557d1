"""One subscription of the probe: how often it is read, what of it is sent, its rates."""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.interfaces import full_type
from launcher.ros.probe.new_arrivals import NO_STAMP, NewArrivals, stamp_ns
from launcher.ros.probe.probe_snapshot import ProbeSnapshot
from launcher.ros.probe.protocol import NANOS, ProbeRequest
from launcher.ros.probe.topic_traffic import Traffic
from launcher.ros.snapshot.ros_graph import Endpoint
from launcher.ros.topics import statistics
from launcher.ros.topics.listener import Listener, ReceivedMessage, TopicTarget, full_topic
from launcher.ros.topics.raw import RawMessage

DEPTH = 2000  # messages that wait for us: 0.4 s of a topic with 5000 a second
KEPT_TIMES = 20_000
LISTEN_PERIOD_S = 0.01  # the middleware stamps messages, so they can wait
_COUNT_PERIOD_S = 0.2  # of those that are read raw, with DEPTH
# Those that are only counted are read by each request, as twice a second, so that they need not be
# read in between; 2500 messages a second that begin at once are DEPTH in this time and a period.
_REST_S = 0.6
_BUSY = 0.05  # this part of the depth in one period makes the next one short
_RATE_NAMES = ("mean_s", "min_s", "max_s", "std_dev_s")


@dataclass(slots=True, kw_only=True)
class Subscription:
    """`qos` None: fitted. Times are monotonic nanoseconds of the receptions.

    `profile` is that of the subscription, `endpoint` the last one that there was.
    `newest` is a message that waits for the end of its period, with `most_hz`; `left_out` counts
    those that it replaced. `stamps`: they are wanted; `has_stamps`: the type has some.
    """

    key: str
    topic: str
    type: str | None
    qos: dict[str, Any] | None
    pushes: bool
    depth: int
    stamps: bool = False
    has_stamps: bool = False
    most_hz: float | None = None
    listener: Listener | None = None
    profile: object = None
    endpoint: Endpoint | None = None
    error: str | None = None
    has_failed: bool = False
    reported: set[str] = field(default_factory=set)
    times_ns: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT_TIMES))
    count: int = 0
    size_bytes: int = 0
    traffic: Traffic = field(default_factory=Traffic)
    arrivals: NewArrivals = field(default_factory=NewArrivals)
    since_ns: int = field(default_factory=time.monotonic_ns)
    due_s: float = 0.0
    newest: ReceivedMessage | None = None
    left_out: int = 0
    next_push_s: float = 0.0

    @property
    def is_raw(self) -> bool:
        """Whether messages are read only when they are sent, if at all."""
        return not self.pushes or self.most_hz is not None

    def plan(self, found: int, listen_s: float) -> None:
        """Set when it is read again, after `found` messages; in step with the others."""
        period_s, rest_s = listen_s, 0.0
        if self.is_raw and found <= self.depth * _BUSY:
            share = min(1.0, self.depth / DEPTH)
            limit_s = _COUNT_PERIOD_S * share
            if self.most_hz is not None:
                limit_s = min(limit_s, 0.5 / self.most_hz)
            elif not self.pushes:
                rest_s = _REST_S * share
            period_s = max(listen_s, limit_s)
        self.due_s = (time.monotonic() // period_s + 1) * period_s + rest_s

    def count_in(self, at_ns: int, size_bytes: int, is_history: bool) -> None:
        self.times_ns.append(at_ns)
        self.count += 1
        self.size_bytes += size_bytes
        if not is_history:
            self.traffic.add(at_ns, size_bytes)

    def note_in(self, raw: RawMessage, is_history: bool, offset_ns: int) -> None:
        """The same of a message that is not sent: its times are kept for `arrivals_document`."""
        at_ns = raw.received_ns - offset_ns
        self.count_in(at_ns, len(raw.data), is_history)
        if not is_history:
            found_ns = stamp_ns(raw.data) if self.has_stamps else NO_STAMP
            self.arrivals.add(at_ns, raw.source_ns, found_ns)

    def hold(self, sample: ReceivedMessage) -> None:
        """Keep the newest message for the end of the period."""
        self.left_out += self.newest is not None
        self.newest = sample

    def release(self) -> tuple[ReceivedMessage, int] | None:
        """The newest message and how many it replaced, once the period has ended."""
        now_s = time.monotonic()
        if self.newest is None or self.most_hz is None or now_s < self.next_push_s:
            return None
        period_s = 1.0 / self.most_hz
        is_steady = now_s - self.next_push_s < period_s
        self.next_push_s = (self.next_push_s if is_steady else now_s) + period_s
        found = self.newest, self.left_out
        self.newest, self.left_out = None, 0
        return found

    def traffic_document(self, now_ns: int) -> dict[str, Any]:
        rate_hz = self.traffic.rate_hz(now_ns, self.since_ns)
        return {
            "topic": self.topic,
            "rate_hz": rate_hz,
            "bytes_per_s": rate_hz * self.traffic.mean_bytes() if self.is_raw else None,
            "age_s": (now_ns - self.times_ns[-1]) / NANOS if self.times_ns else None,
            "count": self.count,
            **self._state(),
        }

    def arrivals_document(self) -> dict[str, Any]:
        """What has arrived since the last time, without the history of the topic."""
        times = self.arrivals.document(stamped=self.has_stamps)
        return {"topic": self.topic, "count": self.count, **times, **self._state()}

    def _state(self) -> dict[str, Any]:
        waiting = "waiting" if self.error is None else "failed"
        return {
            "state": waiting if self.listener is None else "subscribed",
            "error": self.error,
        }

    def rate_document(self, start_ns: int, end_ns: int) -> dict[str, Any]:
        """The rate of received messages in a time span."""
        times_ns = [at_ns for at_ns in self.times_ns if start_ns <= at_ns <= end_ns]
        forgotten = self.count > KEPT_TIMES and self.times_ns[0] > start_ns
        return {
            **_rate(times_ns, end_ns),
            "bytes_mean": self.size_bytes / max(1, self.count) if self.is_raw else None,
            "complete": not forgotten,
        }


def subscription_of(request: ProbeRequest) -> Subscription:
    """VerbError for fields that do not fit."""
    most_hz = request.optional_number("most_hz")
    if most_hz is not None and not 0 < most_hz < math.inf:
        raise VerbError("'most_hz' must be greater than 0", hint="without it all messages are sent")
    pushes, stamps = request.flag("messages", True), request.flag("stamps", False)
    if stamps and pushes:
        raise VerbError("'stamps' needs 'messages': false", hint="messages have their stamps")
    return Subscription(
        key=request.text("sub"),
        topic=full_topic(request.text("topic")),
        type=request.optional_text("type"),
        qos=request.mapping("qos"),
        pushes=pushes,
        stamps=stamps,
        depth=int(request.number("depth", DEPTH)),
        most_hz=most_hz,
    )


def target_of(sub: Subscription, snapshot: ProbeSnapshot) -> TopicTarget | None:
    """What to subscribe to; None while its type or its publishers are unknown."""
    endpoints = snapshot.on(sub.topic)
    types = snapshot.types_of(sub.topic)
    if sub.type is None and len(types) > 1:
        raise VerbError(
            f"topic '{sub.topic}' has more than one type: {', '.join(types)}",
            hint="add the type to the request",
        )
    type_name = sub.type or next(iter(types), None)
    if type_name is None:
        return None
    wanted = full_type(type_name)
    publishers = tuple(e for e in endpoints if e.is_publisher and e.type == wanted)
    if sub.qos is None and not publishers:
        return None
    return TopicTarget(name=sub.topic, type=wanted, publishers=publishers)


def _rate(times_ns: list[int], end_ns: int) -> dict[str, Any]:
    arrivals = statistics.Arrivals(max(1, len(times_ns)))
    for at_ns in times_ns:
        arrivals.add(at_ns)
    spread = arrivals.now()
    return {
        "count": len(times_ns),
        "rate_hz": arrivals.mean_rate_hz(end_ns),
        **{name: None if spread is None else getattr(spread, name) for name in _RATE_NAMES},
        "first": times_ns[0] / NANOS if times_ns else None,
        "last": times_ns[-1] / NANOS if times_ns else None,
        "silent_s": (end_ns - times_ns[-1]) / NANOS if times_ns else None,
    }
