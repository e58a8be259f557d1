"""The probe's subscriptions, with QoS that is given or fitted to the publishers.

A fitted one is created when the first publisher is known, and replaced by a weaker one if a
publisher comes that it does not match. It never becomes stronger: that could only lose messages.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from launcher.ros.discovery.observer import Observer
from launcher.ros.errors import VerbError
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import full_type, load_message
from launcher.ros.messages.to_yaml import to_plain
from launcher.ros.probe.protocol import NANOS, Outbox, Request, moment, wall_offset_ns
from launcher.ros.probe.snapshot import ProbeSnapshot
from launcher.ros.snapshot.graph import Direction, Endpoint
from launcher.ros.snapshot.qos_matching import explain, faults
from launcher.ros.topics import qos, statistics
from launcher.ros.topics.listener import Listener, Sample, Target, full_topic

DEPTH = 2000  # messages that wait for us: 0.4 s of a topic with 5000 a second
KEPT_TIMES = 20_000


@dataclass(slots=True, kw_only=True)
class Subscription:
    """One subscription. `qos` None: fitted. Times are monotonic nanoseconds of the receptions."""

    key: str
    topic: str
    type: str | None
    qos: dict[str, Any] | None
    pushes: bool
    depth: int
    listener: Listener | None = None
    endpoint: Endpoint | None = None
    has_failed: bool = False
    reported: set[str] = field(default_factory=set)
    times_ns: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT_TIMES))
    count: int = 0
    size_bytes: int = 0


class Subscriptions:
    def __init__(self, observer: Observer, outbox: Outbox) -> None:
        self._observer = observer
        self._outbox = outbox
        self._subscriptions: dict[str, Subscription] = {}

    def __len__(self) -> int:
        return len(self._subscriptions)

    def subscribe(self, request: Request, snapshot: ProbeSnapshot) -> dict[str, Any]:
        """Add one; VerbError for a request that can never work."""
        sub = Subscription(
            key=request.text("sub"),
            topic=full_topic(request.text("topic")),
            type=request.optional_text("type"),
            qos=request.mapping("qos"),
            pushes=request.flag("messages", True),
            depth=int(request.number("depth", DEPTH)),
        )
        if sub.key in self._subscriptions:
            raise VerbError(f"duplicate subscription '{sub.key}'")
        if sub.type is not None:
            with_library(load_message(sub.type))
        if sub.qos is not None:
            qos.from_words(sub.qos, sub.depth)
        self._subscriptions[sub.key] = sub
        self._update(sub, snapshot)
        return {"state": "waiting" if sub.listener is None else "subscribed"}

    def unsubscribe(self, request: Request) -> dict[str, Any]:
        sub = self._sub(request)
        del self._subscriptions[sub.key]
        if sub.listener is not None:
            sub.listener.close()
        return {}

    def _sub(self, request: Request) -> Subscription:
        key = request.text("sub")
        if key not in self._subscriptions:
            raise VerbError(f"unknown subscription '{key}'")
        return self._subscriptions[key]

    def fit(self, snapshot: ProbeSnapshot) -> None:
        """Take a new snapshot: subscribe where it has become possible, report mismatches."""
        for sub in self._subscriptions.values():
            self._update(sub, snapshot)

    def _update(self, sub: Subscription, snapshot: ProbeSnapshot) -> None:
        self._fit(sub, snapshot)
        if sub.endpoint is not None:
            self._report_mismatches(sub, sub.endpoint, snapshot)

    def _fit(self, sub: Subscription, snapshot: ProbeSnapshot) -> None:
        try:
            target = _target(sub, snapshot)
            if target is not None and self._is_needed(sub, target):
                self._make(sub, target)
        except VerbError as error:
            if not sub.has_failed:
                sub.has_failed = True
                text = {"message": error.message, "hint": error.hint}
                self._outbox.send({"event": "failed", "sub": sub.key, **text, **moment()})

    def _is_needed(self, sub: Subscription, target: Target) -> bool:
        """Whether a subscription has to be created, the first or a weaker one."""
        if sub.endpoint is None:
            return True
        own = sub.endpoint
        return sub.qos is None and any(faults(p, own) for p in target.publishers)

    def _make(self, sub: Subscription, target: Target) -> None:
        if sub.qos is None:
            profile, _ = qos.listening(target.publishers, sub.depth)
        else:
            profile = qos.from_words(sub.qos, sub.depth)
        listener = Listener(self._observer, raw=not sub.pushes)
        listener.subscribe(target, profile)
        before, sub.listener = sub.listener, listener
        if before is not None:
            self._keep(sub, before.take())
            before.close()
        sub.endpoint = qos.endpoint_of(
            profile, Direction.SUBSCRIPTION, target.name, target.type, node="this subscription"
        )
        self._outbox.send(
            {
                "event": "subscribed",
                "sub": sub.key,
                "topic": sub.topic,
                "type": sub.endpoint.type,
                "qos": qos.to_words(profile),
                "fitted": sub.qos is None,
                "again": before is not None,
                **moment(),
            }
        )

    def _report_mismatches(self, sub: Subscription, own: Endpoint, snapshot: ProbeSnapshot) -> None:
        publishers = [e for e in snapshot.on(sub.topic) if e.is_publisher]
        policies = {f.policy for p in publishers for f in faults(p, own)}
        text = explain([*publishers, own])
        if policies and text not in sub.reported:
            sub.reported.add(text)
            names = {"sub": sub.key, "topic": sub.topic}
            found = {"text": text, "policies": sorted(policies)}
            self._outbox.send({"event": "mismatch", **names, **found, **moment()})

    def matching(self, publisher: Endpoint) -> int:
        """How many of our own subscriptions match this publisher."""
        own = [w.endpoint for w in list(self._subscriptions.values()) if w.endpoint]
        return sum(e.topic == publisher.topic and not faults(publisher, e) for e in own)

    def take(self) -> None:
        for sub in self._subscriptions.values():
            if sub.listener is not None and (samples := sub.listener.take()):
                self._keep(sub, samples)

    def _keep(self, sub: Subscription, samples: list[Sample]) -> None:
        offset_ns = wall_offset_ns()
        for sample in samples:
            sub.times_ns.append(sample.received_ns - offset_ns)
            sub.count += 1
            if sub.pushes:
                self._push(sub, sample, offset_ns)
            else:
                sub.size_bytes += len(sample.message)

    def _push(self, sub: Subscription, sample: Sample, offset_ns: int) -> None:
        self._outbox.push(
            {
                "event": "message",
                "sub": sub.key,
                "topic": sub.topic,
                "mono": (sample.received_ns - offset_ns) / NANOS,
                "wall": sample.received_ns / NANOS,
                "sent": int(sample.info["source_timestamp"]) / NANOS,
                "data": to_plain(sample.message),
            }
        )

    def rate(self, request: Request) -> dict[str, Any]:
        """The rate of received messages in a time span."""
        sub = self._sub(request)
        from_s, until_s = request.optional_number("from"), request.optional_number("until")
        start_ns = 0 if from_s is None else round(from_s * NANOS)
        end_ns = time.monotonic_ns() if until_s is None else round(until_s * NANOS)
        times_ns = [at_ns for at_ns in sub.times_ns if start_ns <= at_ns <= end_ns]
        forgotten = sub.count > KEPT_TIMES and sub.times_ns[0] > start_ns
        return {
            **_rate_document(times_ns, end_ns),
            "bytes_mean": None if sub.pushes else sub.size_bytes / max(1, sub.count),
            "complete": not forgotten,
        }


def _target(sub: Subscription, snapshot: ProbeSnapshot) -> Target | None:
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
    return Target(name=sub.topic, type=wanted, publishers=publishers)


def _rate_document(times_ns: list[int], end_ns: int) -> dict[str, Any]:
    arrivals = statistics.Arrivals(max(1, len(times_ns)))
    for at_ns in times_ns:
        arrivals.add(at_ns)
    spread = arrivals.now()
    names = ("mean_s", "min_s", "max_s", "std_dev_s")
    return {
        "count": len(times_ns),
        "rate_hz": arrivals.mean_rate_hz(end_ns),
        **{name: None if spread is None else getattr(spread, name) for name in names},
        "first": times_ns[0] / NANOS if times_ns else None,
        "last": times_ns[-1] / NANOS if times_ns else None,
        "silent_s": (end_ns - times_ns[-1]) / NANOS if times_ns else None,
    }
