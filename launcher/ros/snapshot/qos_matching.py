"""Which publishers and subscriptions of a topic do not match, why, and what to change.

DDS matches a publisher with subscriptions that request no more than it offers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from launcher.ros.snapshot.ros_graph import INFINITE_NS, Endpoint, TopicGraph

_NANOS = 1_000_000_000


class Roles(NamedTuple):
    """What the two sides are called, and what the second does not receive."""

    writer: str = "publisher"
    reader: str = "subscription"
    nothing: str = "nothing"


REQUESTS, RESPONSES = (
    Roles("client", "server", "no requests"),
    Roles("server", "client", "no responses"),
)
_TOPIC = Roles()


@dataclass(frozen=True, slots=True, kw_only=True)
class QosMismatch:
    """A policy that does not match; its values as words."""

    policy: str
    offered: str
    requested: str

    @property
    def advice(self) -> str:
        return self.advice_for(_TOPIC)

    def advice_for(self, roles: Roles) -> str:
        if self.policy == "TYPE":
            return f"use one type on both sides: {self.offered} or {self.requested}"
        noun = self.policy.lower().replace("_", " ")
        wanted = self.requested
        reader, writer = f"the {roles.reader}'s {noun}", f"the {roles.writer}'s"
        return f"set {reader} to {self.offered}, or {writer} to {wanted}"


def faults(publisher: Endpoint, subscription: Endpoint) -> list[QosMismatch]:
    """Every policy that does not match; empty if the pair does."""
    return list(_faults(publisher, subscription))


def _faults(publisher: Endpoint, subscription: Endpoint) -> Iterator[QosMismatch]:
    if publisher.type != subscription.type:
        yield QosMismatch(policy="TYPE", offered=publisher.type, requested=subscription.type)
    for policy, lesser, greater in (
        ("reliability", "BEST_EFFORT", "RELIABLE"),
        ("durability", "VOLATILE", "TRANSIENT_LOCAL"),
        ("liveliness", "AUTOMATIC", "MANUAL_BY_TOPIC"),
    ):
        offered, requested = getattr(publisher, policy), getattr(subscription, policy)
        if (offered, requested) == (lesser, greater):
            yield QosMismatch(policy=policy.upper(), offered=offered, requested=requested)
    if publisher.deadline_ns > subscription.deadline_ns:
        yield _times("DEADLINE", publisher.deadline_ns, subscription.deadline_ns)
    if publisher.lease_ns > subscription.lease_ns:
        yield _times("LIVELINESS_LEASE_DURATION", publisher.lease_ns, subscription.lease_ns)


def _times(policy: str, offered_ns: int, requested_ns: int) -> QosMismatch:
    return QosMismatch(
        policy=policy, offered=_seconds(offered_ns), requested=_seconds(requested_ns)
    )


def _seconds(duration_ns: int) -> str:
    return "infinite" if duration_ns >= INFINITE_NS else f"{duration_ns / _NANOS:g} s"


def mismatched_policy(publisher: Endpoint, subscription: Endpoint) -> str | None:
    """The first policy that does not match; None if the pair does."""
    found = faults(publisher, subscription)
    return found[0].policy if found else None


def silent_subscriptions(snapshot: TopicGraph) -> dict[Endpoint, str]:
    """Subscriptions that match none of their topic's publishers, and a policy that differs."""
    silent: dict[Endpoint, str] = {}
    for subscription in snapshot.endpoints:
        if subscription.is_publisher:
            continue
        policies = [
            mismatched_policy(publisher, subscription)
            for publisher in snapshot.on(subscription.topic)
            if publisher.is_publisher
        ]
        if policies and None not in policies:
            silent[subscription] = policies[0] or ""
    return silent


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class TopicLink:
    """Two nodes connected by a topic; `fault` is a policy that does not match."""

    source: str
    target: str
    topic: str
    fault: str | None = None


def links(endpoints: Iterable[Endpoint]) -> list[TopicLink]:
    """Every pair of nodes that share a topic, sorted; a matching pair hides one that does not."""
    known = sorted(set(endpoints))
    found: dict[tuple[str, str, str], str | None] = {}
    for publisher in (e for e in known if e.is_publisher):
        for subscription in (e for e in known if not e.is_publisher):
            if publisher.topic == subscription.topic:
                key = (publisher.node, subscription.node, publisher.topic)
                fault = mismatched_policy(publisher, subscription)
                found[key] = None if found.get(key, fault) is None else fault
    return [
        TopicLink(source=source, target=target, topic=topic, fault=fault)
        for (source, target, topic), fault in sorted(found.items())
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mismatch:
    """Publishers that do not match one subscription, all for the same reasons."""

    subscription: Endpoint
    publishers: tuple[Endpoint, ...]
    faults: tuple[QosMismatch, ...]


def mismatches(endpoints: Iterable[Endpoint]) -> list[Mismatch]:
    """All pairs of one topic that do not match, grouped by subscription and reasons."""
    known = sorted(endpoints)
    found: list[Mismatch] = []
    for subscription in (e for e in known if not e.is_publisher):
        reasons: dict[tuple[QosMismatch, ...], list[Endpoint]] = {}
        for publisher in (e for e in known if e.is_publisher):
            if pair := tuple(faults(publisher, subscription)):
                reasons.setdefault(pair, []).append(publisher)
        found += [
            Mismatch(subscription=subscription, publishers=tuple(publishers), faults=pair)
            for pair, publishers in reasons.items()
        ]
    return found


def explain(endpoints: Iterable[Endpoint], roles: Roles = _TOPIC) -> str:
    """The mismatches of a topic in sentences; one sentence if there are none.

    A service has two topics of DDS, for its `REQUESTS` and its `RESPONSES`.
    """
    known = list(endpoints)
    publishers = sum(e.is_publisher for e in known)
    pairs = publishers * (len(known) - publishers)
    found = mismatches(known)
    if not found:
        return f"QoS: {_match(pairs)}"
    bad = sum(len(m.publishers) for m in found)
    noun = f"pair of {roles.writer} and {roles.reader} does" if bad == 1 else "pairs do"
    return "\n".join([f"QoS: {bad} of {pairs} {noun} not match", *_sentences(found, roles)])


def _match(pairs: int) -> str:
    if pairs == 0:
        return "no pair of publisher and subscription to compare"
    return "the pair matches" if pairs == 1 else f"all {pairs} pairs match"


def _sentences(found: list[Mismatch], roles: Roles) -> Iterator[str]:
    for mismatch in found:
        names = ", ".join(e.shown_node for e in mismatch.publishers)
        yield f"  {mismatch.subscription.shown_node} receives {roles.nothing} from {names}"
        for fault in mismatch.faults:
            yield (
                f"    {fault.policy}: the {roles.writer} offers {fault.offered}, "
                f"the {roles.reader} asks for {fault.requested}"
            )
            yield f"    to repair: {fault.advice_for(roles)}"
