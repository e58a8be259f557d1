"""Snapshot: the endpoints of a ROS graph at one moment, as plain data."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass, replace

# Topics that every node has; they hide the picture of what the system does.
DEBUG_TOPICS = frozenset({"/rosout", "/parameter_events"})

INFINITE_NS = 2**63 - 1


class Direction(enum.Enum):
    """Which way messages go through an endpoint."""

    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Endpoint:
    """A publisher or a subscription; `node` and `topic` are full names, QoS as ROS names it.

    `gid` is dotted hex, empty if unknown; times are nanoseconds.
    """

    topic: str
    node: str
    direction: str
    type: str
    reliability: str
    durability: str
    liveliness: str = "AUTOMATIC"
    deadline_ns: int = INFINITE_NS
    lease_ns: int = INFINITE_NS
    gid: str = ""

    @property
    def is_publisher(self) -> bool:
        """Whether messages come out of it."""
        return self.direction == Direction.PUBLISHER.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """Nodes (full names, twice if two share one) and endpoints, sorted.

    `ghosts` are the nodes whose process is gone and that the graph has not forgotten yet.
    """

    nodes: tuple[str, ...]
    endpoints: tuple[Endpoint, ...]
    ghosts: tuple[str, ...] = ()

    def without(self, topics: Iterable[str]) -> Snapshot:
        """The same graph without these topics."""
        hidden = frozenset(topics)
        kept = tuple(e for e in self.endpoints if e.topic not in hidden)
        return replace(self, endpoints=kept)

    def topics(self) -> tuple[str, ...]:
        """Every topic that has an endpoint, sorted."""
        return tuple(sorted({e.topic for e in self.endpoints}))

    def on(self, topic: str) -> tuple[Endpoint, ...]:
        """The endpoints of one topic."""
        return tuple(e for e in self.endpoints if e.topic == topic)


def is_hidden(name: str) -> bool:
    """Whether a part of the name begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))
