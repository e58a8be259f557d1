"""Snapshot: the endpoints of a ROS graph at one moment, as plain data."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass

# Topics that every node has; they hide the picture of what the system does.
DEBUG_TOPICS = frozenset({"/rosout", "/parameter_events"})


class Direction(enum.Enum):
    """Which way messages go through an endpoint."""

    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Endpoint:
    """A publisher or a subscription; `node` and `topic` are full names, QoS as ROS names it."""

    topic: str
    node: str
    direction: str
    type: str
    reliability: str
    durability: str

    @property
    def is_publisher(self) -> bool:
        """Whether messages come out of it."""
        return self.direction == Direction.PUBLISHER.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """Nodes (full names) and endpoints, sorted."""

    nodes: tuple[str, ...]
    endpoints: tuple[Endpoint, ...]

    def without(self, topics: Iterable[str]) -> Snapshot:
        """The same graph without these topics."""
        hidden = frozenset(topics)
        kept = tuple(e for e in self.endpoints if e.topic not in hidden)
        return Snapshot(nodes=self.nodes, endpoints=kept)

    def topics(self) -> tuple[str, ...]:
        """Every topic that has an endpoint, sorted."""
        return tuple(sorted({e.topic for e in self.endpoints}))


def mismatched_policy(publisher: Endpoint, subscription: Endpoint) -> str | None:
    """The QoS policy because of which this pair exchanges nothing; None if the pair matches.

    DDS's rule of request and offer: a subscription may not ask for more than is offered.
    """
    if publisher.type != subscription.type:
        return "TYPE"
    if (publisher.reliability, subscription.reliability) == ("BEST_EFFORT", "RELIABLE"):
        return "RELIABILITY"
    if (publisher.durability, subscription.durability) == ("VOLATILE", "TRANSIENT_LOCAL"):
        return "DURABILITY"
    return None


def silent_subscriptions(snapshot: Snapshot) -> dict[Endpoint, str]:
    """Subscriptions that get nothing although their topic has publishers, and the policy why."""
    silent: dict[Endpoint, str] = {}
    for subscription in snapshot.endpoints:
        if subscription.is_publisher:
            continue
        policies = [
            mismatched_policy(publisher, subscription)
            for publisher in snapshot.endpoints
            if publisher.is_publisher and publisher.topic == subscription.topic
        ]
        if policies and None not in policies:
            silent[subscription] = policies[0] or ""
    return silent
