"""The probe's subscriptions, with QoS that is given or fitted to the publishers.

A fitted one is created when the first publisher is known, and replaced when another profile fits
them: `launcher.ros.topics.fitted`.
"""

from __future__ import annotations

import math
import time
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.serialization import deserialize_message

from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.messages.to_yaml import to_plain
from launcher.ros.probe.new_arrivals import has_stamp
from launcher.ros.probe.probe_snapshot import ProbeSnapshot
from launcher.ros.probe.protocol import NANOS, LineOutbox, ProbeRequest, moment, wall_offset_ns
from launcher.ros.probe.subscription import (
    LISTEN_PERIOD_S,
    Subscription,
    subscription_of,
    target_of,
)
from launcher.ros.snapshot.qos_matching import explain, faults
from launcher.ros.snapshot.ros_graph import Endpoint
from launcher.ros.topics import qos
from launcher.ros.topics.listener import Listener, ReceivedMessage, TopicTarget
from launcher.ros.topics.raw import RawTaker

_Fields = dict[str, Any]


class Subscriptions:
    def __init__(self, observer: Observer, outbox: LineOutbox) -> None:
        self._observer = observer
        self._outbox = outbox
        self._subscriptions: dict[str, Subscription] = {}
        self._taker = RawTaker()
        self._due_s = 0.0  # the earliest of all, while no subscription has changed
        self.listen_s = LISTEN_PERIOD_S

    def subscribe(self, request: ProbeRequest, snapshot: ProbeSnapshot) -> dict[str, Any]:
        """Add one; VerbError for a request that can never work."""
        sub = subscription_of(request)
        if sub.key in self._subscriptions:
            raise VerbError(f"duplicate subscription '{sub.key}'")
        if sub.type is not None:
            with_library(load_message(sub.type))
        if sub.qos is not None:
            qos.from_words(sub.qos, sub.depth)
        self._subscriptions[sub.key] = sub
        self._update(sub, snapshot)
        return {"state": "waiting" if sub.listener is None else "subscribed"}

    def unsubscribe(self, request: ProbeRequest) -> dict[str, Any]:
        sub = self._sub(request)
        del self._subscriptions[sub.key]
        if sub.listener is not None:
            sub.listener.close()
        return {}

    def _sub(self, request: ProbeRequest) -> Subscription:
        key = request.text("sub")
        if key not in self._subscriptions:
            raise VerbError(f"unknown subscription '{key}'")
        return self._subscriptions[key]

    def fit(self, snapshot: ProbeSnapshot) -> None:
        """Take a new snapshot: subscribe where it has become possible, report mismatches."""
        for sub in self._subscriptions.values():
            self._update(sub, snapshot)

    def _update(self, sub: Subscription, snapshot: ProbeSnapshot) -> None:
        self._due_s = 0.0
        self._fit(sub, snapshot)
        if sub.endpoint is not None:
            self._report_mismatches(sub, sub.endpoint, snapshot)

    def _fit(self, sub: Subscription, snapshot: ProbeSnapshot) -> None:
        sub.error = None
        try:
            target = target_of(sub, snapshot)
            if sub.listener is not None and sub.qos is None:
                sub.listener.fit(sub.topic, () if target is None else target.publishers)
            elif sub.listener is None and target is not None:
                sub.listener = self._listener(sub, target)
            if sub.listener is not None:
                self._note_profile(sub, sub.listener)
        except VerbError as error:
            sub.error = error.message
            if not sub.has_failed:
                sub.has_failed = True
                text = {"message": error.message, "hint": error.hint}
                self._outbox.send({"event": "failed", "sub": sub.key, **text, **moment()})

    def _listener(self, sub: Subscription, target: TopicTarget) -> Listener:
        listener = Listener(self._observer, raw=sub.is_raw, taker=self._taker)
        profile = None if sub.qos is None else qos.from_words(sub.qos, sub.depth)
        listener.subscribe(target, profile, sub.depth)
        kind = load_message(target.type)
        sub.has_stamps = sub.stamps and has_stamp(kind.get_fields_and_field_types())
        return listener

    def _note_profile(self, sub: Subscription, listener: Listener) -> None:
        """Report another subscription."""
        profile = listener.profile(sub.topic)
        if profile is None or profile is sub.profile:
            sub.profile = profile
            return
        is_again = sub.endpoint is not None
        sub.profile = profile
        sub.endpoint = listener.endpoint(sub.topic, "this subscription")
        self._outbox.send(
            {
                "event": "subscribed",
                "sub": sub.key,
                "topic": sub.topic,
                "type": sub.endpoint.type,
                "qos": qos.to_words(profile),
                "fitted": sub.qos is None,
                "again": is_again,
                **moment(),
            }
        )

    def _report_mismatches(self, sub: Subscription, own: Endpoint, snapshot: ProbeSnapshot) -> None:
        publishers = [e for e in snapshot.on(sub.topic) if e.is_publisher]
        policies = {f.policy for p in publishers for f in faults(p, own)}
        if policies and (text := explain([*publishers, own])) not in sub.reported:
            sub.reported.add(text)
            names = {"sub": sub.key, "topic": sub.topic}
            found = {"text": text, "policies": sorted(policies)}
            self._outbox.send({"event": "mismatch", **names, **found, **moment()})

    def matching(self, publisher: Endpoint) -> int:
        """How many of our own subscriptions match this publisher."""
        own = [w.endpoint for w in list(self._subscriptions.values()) if w.profile and w.endpoint]
        return sum(e.topic == publisher.topic and not faults(publisher, e) for e in own)

    @property
    def due_s(self) -> float:
        """When to `take` again; infinite without subscriptions."""
        return self._due_s

    def take(self, *, everything: bool = False) -> None:
        """Read those that are due, or all."""
        now_s = time.monotonic()
        if now_s < self._due_s and not everything:
            return
        due_s = math.inf
        for sub in self._subscriptions.values():
            if sub.listener is not None:
                if everything or now_s >= sub.due_s:
                    self._read(sub, sub.listener)
                due_s = min(due_s, sub.due_s)
        self._due_s = due_s

    def _read(self, sub: Subscription, listener: Listener) -> None:
        found = self._forward(sub, listener) if sub.pushes else _counted(sub, listener)
        sub.plan(found, self.listen_s)

    def _forward(self, sub: Subscription, listener: Listener) -> int:
        """Send what has come, or keep it for the end of the period; the number of messages."""
        samples = listener.take()
        if samples:
            self._keep(sub, samples)
        if (released := sub.release()) is not None:
            sample, left_out = released
            self._push(sub, sample, wall_offset_ns(), {"skipped": left_out})
        return len(samples)

    def _keep(self, sub: Subscription, samples: list[ReceivedMessage]) -> None:
        offset_ns = wall_offset_ns()
        for sample in samples:
            size_bytes = len(sample.message) if sub.is_raw else 0
            sub.count_in(sample.received_ns - offset_ns, size_bytes, sample.is_history)
            if sub.most_hz is None:
                self._push(sub, sample, offset_ns, {})
            else:
                sub.hold(sample)

    def _push(
        self, sub: Subscription, sample: ReceivedMessage, offset_ns: int, more: _Fields
    ) -> None:
        self._outbox.push(
            {
                "event": "message",
                "sub": sub.key,
                "topic": sub.topic,
                "mono": (sample.received_ns - offset_ns) / NANOS,
                "wall": sample.received_ns / NANOS,
                "sent": int(sample.info["source_timestamp"]) / NANOS,
                **(_contents(sub, sample) if sub.is_raw else {"data": to_plain(sample.message)}),
                **more,
            }
        )

    def rate(self, request: ProbeRequest) -> dict[str, Any]:
        """The rate of received messages in a time span."""
        sub = self._sub(request)
        from_s, until_s = request.optional_number("from"), request.optional_number("until")
        start_ns = 0 if from_s is None else round(from_s * NANOS)
        end_ns = time.monotonic_ns() if until_s is None else round(until_s * NANOS)
        return sub.rate_document(start_ns, end_ns)

    def traffic(self) -> dict[str, Any]:
        """What arrives now, of all subscriptions."""
        now_ns = time.monotonic_ns()
        subs = {key: sub.traffic_document(now_ns) for key, sub in self._subscriptions.items()}
        return {"mono": now_ns / NANOS, "subs": subs}

    def arrivals(self, request: ProbeRequest) -> dict[str, Any]:
        """What has arrived since the last time, of the subscriptions that send no messages.

        Without those that have nothing new, if `silent` of the request is false.
        """
        counted = {key: sub for key, sub in self._subscriptions.items() if not sub.pushes}
        if not request.flag("silent", True):
            counted = {key: sub for key, sub in counted.items() if sub.arrivals}
        subs = {key: sub.arrivals_document() for key, sub in counted.items()}
        return {**moment(), "subs": subs}


def _counted(sub: Subscription, listener: Listener) -> int:
    """Note when messages have come; how many."""
    taken = listener.take_raw()
    offset_ns = wall_offset_ns()
    for raw, is_history in taken:
        sub.note_in(raw, is_history, offset_ns)
    return len(taken)


def _contents(sub: Subscription, sample: ReceivedMessage) -> _Fields:
    """The data of a message that was taken raw, or why it cannot be read."""
    assert sub.endpoint is not None
    try:
        message = deserialize_message(sample.message, load_message(sub.endpoint.type))
    except _rclpy.RMWError as error:
        return {"data": None, "error": str(error)}
    return {"data": to_plain(message)}
