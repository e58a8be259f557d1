"""Watches: the probe's subscriptions, each fitted to its publishers or with exactly the QoS asked.

A fitted one is made when the first publisher is known, and made anew, weaker, if another turns up
that it would not match. It never becomes stronger: that could only lose messages.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from launcher.ros.discovery.observer import Observer
from launcher.ros.errors import VerbError
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
OWN_NAME = "this subscription"


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
    told: set[str] = field(default_factory=set)
    times_ns: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT_TIMES))
    count: int = 0
    size_bytes: int = 0


class Subscriptions:
    """All subscriptions of a probe."""

    def __init__(self, observer: Observer, outbox: Outbox) -> None:
        self._observer = observer
        self._outbox = outbox
        self._watches: dict[str, Subscription] = {}

    def __len__(self) -> int:
        return len(self._watches)

    def subscribe(self, request: Request, portrait: ProbeSnapshot) -> dict[str, Any]:
        """Begin; VerbError for a request that can never work."""
        watch = Subscription(
            key=request.text("sub"),
            topic=full_topic(request.text("topic")),
            type=request.optional_text("type"),
            qos=request.mapping("qos"),
            pushes=request.flag("messages", True),
            depth=int(request.number("depth", DEPTH)),
        )
        if watch.key in self._watches:
            raise VerbError(f"there is a subscription '{watch.key}' already")
        if watch.type is not None:
            load_message(watch.type)
        if watch.qos is not None:
            qos.from_words(watch.qos, watch.depth)
        self._watches[watch.key] = watch
        self._look(watch, portrait)
        return {"state": "waiting" if watch.listener is None else "subscribed"}

    def unsubscribe(self, request: Request) -> dict[str, Any]:
        """End one."""
        watch = self._watch(request)
        del self._watches[watch.key]
        if watch.listener is not None:
            watch.listener.close()
        return {}

    def _watch(self, request: Request) -> Subscription:
        key = request.text("sub")
        if key not in self._watches:
            raise VerbError(f"there is no subscription '{key}'")
        return self._watches[key]

    def fit(self, portrait: ProbeSnapshot) -> None:
        """Look at a new graph: subscribe where it has become possible, say what cannot match."""
        for watch in self._watches.values():
            self._look(watch, portrait)

    def _look(self, watch: Subscription, portrait: ProbeSnapshot) -> None:
        self._fit(watch, portrait)
        if watch.endpoint is not None:
            self._tell_mismatches(watch, watch.endpoint, portrait)

    def _fit(self, watch: Subscription, portrait: ProbeSnapshot) -> None:
        try:
            target = _target(watch, portrait)
            if target is not None and self._is_wanting(watch, target):
                self._make(watch, target)
        except VerbError as error:
            if not watch.has_failed:
                watch.has_failed = True
                text = {"message": error.message, "hint": error.hint}
                self._outbox.say({"event": "failed", "sub": watch.key, **text, **moment()})

    def _is_wanting(self, watch: Subscription, target: Target) -> bool:
        """Whether a subscription has to be made, for the first time or a weaker one."""
        if watch.endpoint is None:
            return True
        own = watch.endpoint
        return watch.qos is None and any(faults(p, own) for p in target.publishers)

    def _make(self, watch: Subscription, target: Target) -> None:
        if watch.qos is None:
            profile, _ = qos.listening(target.publishers, watch.depth)
        else:
            profile = qos.from_words(watch.qos, watch.depth)
        listener = Listener(self._observer, raw=not watch.pushes)
        listener.subscribe(target, profile)
        before, watch.listener = watch.listener, listener
        if before is not None:
            self._keep(watch, before.take())
            before.close()
        watch.endpoint = own_endpoint(profile, target)
        self._outbox.say(
            {
                "event": "subscribed",
                "sub": watch.key,
                "topic": watch.topic,
                "type": watch.endpoint.type,
                "qos": qos.to_words(profile),
                "fitted": watch.qos is None,
                "again": before is not None,
                **moment(),
            }
        )

    def _tell_mismatches(self, watch: Subscription, own: Endpoint, portrait: ProbeSnapshot) -> None:
        publishers = [e for e in portrait.on(watch.topic) if e.is_publisher]
        policies = {f.policy for p in publishers for f in faults(p, own)}
        text = explain([*publishers, own])
        if policies and text not in watch.told:
            watch.told.add(text)
            names = {"sub": watch.key, "topic": watch.topic}
            found = {"text": text, "policies": sorted(policies)}
            self._outbox.say({"event": "mismatch", **names, **found, **moment()})

    def matching(self, publisher: Endpoint) -> int:
        """How many of our own subscriptions hear this publisher."""
        own = [w.endpoint for w in list(self._watches.values()) if w.endpoint]
        return sum(e.topic == publisher.topic and not faults(publisher, e) for e in own)

    def take(self) -> None:
        """Push and count what has come."""
        for watch in self._watches.values():
            if watch.listener is not None and (samples := watch.listener.take()):
                self._keep(watch, samples)

    def _keep(self, watch: Subscription, samples: list[Sample]) -> None:
        offset_ns = wall_offset_ns()
        for sample in samples:
            watch.times_ns.append(sample.received_ns - offset_ns)
            watch.count += 1
            if watch.pushes:
                self._push(watch, sample, offset_ns)
            else:
                watch.size_bytes += len(sample.message)

    def _push(self, watch: Subscription, sample: Sample, offset_ns: int) -> None:
        self._outbox.hand_over(
            {
                "event": "message",
                "sub": watch.key,
                "topic": watch.topic,
                "mono": (sample.received_ns - offset_ns) / NANOS,
                "wall": sample.received_ns / NANOS,
                "sent": int(sample.info["source_timestamp"]) / NANOS,
                "data": to_plain(sample.message),
            }
        )

    def rate(self, request: Request) -> dict[str, Any]:
        """How often messages came in a span of time."""
        watch = self._watch(request)
        from_s, until_s = request.optional_number("from"), request.optional_number("until")
        start_ns = 0 if from_s is None else round(from_s * NANOS)
        end_ns = time.monotonic_ns() if until_s is None else round(until_s * NANOS)
        times_ns = [at_ns for at_ns in watch.times_ns if start_ns <= at_ns <= end_ns]
        forgotten = watch.count > KEPT_TIMES and watch.times_ns[0] > start_ns
        return {
            **_rate_document(times_ns, end_ns),
            "bytes_mean": None if watch.pushes else watch.size_bytes / max(1, watch.count),
            "complete": not forgotten,
        }


def _target(watch: Subscription, portrait: ProbeSnapshot) -> Target | None:
    """What to subscribe to; None as long as its type or its publishers are not known."""
    endpoints = portrait.on(watch.topic)
    types = portrait.types_of(watch.topic)
    if watch.type is None and len(types) > 1:
        raise VerbError(
            f"topic '{watch.topic}' has more than one type: {', '.join(types)}",
            hint="say which one is meant",
        )
    type_name = watch.type or next(iter(types), None)
    if type_name is None:
        return None
    wanted = full_type(type_name)
    publishers = tuple(e for e in endpoints if e.is_publisher and e.type == wanted)
    if watch.qos is None and not publishers:
        return None
    return Target(name=watch.topic, type=wanted, publishers=publishers)


def own_endpoint(profile: Any, target: Target) -> Endpoint:
    """Our subscription as the graph would show it."""
    return qos.endpoint_of(
        profile,
        topic=target.name,
        type_name=target.type,
        direction=Direction.SUBSCRIPTION,
        node=OWN_NAME,
    )


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
