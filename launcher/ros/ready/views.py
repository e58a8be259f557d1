"""The graph with the time since when each part is there, by discovery messages or by rclpy."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from launcher.ros.snapshot.ros_graph import (
    REQUEST,
    TOPIC,
    Direction,
    Endpoint,
    EndpointInfo,
    ros_name,
    ros_type,
)

if TYPE_CHECKING:
    from launcher.ros.discovery.follower import DiscoveryFollower
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.snapshot.ros_graph import GraphSnapshot

_PREFIX = 12 * 3 - 1  # characters of a participant in the dotted hex of a GID


class GraphPart(NamedTuple):
    """Nodes and endpoints that are there since then (monotonic seconds)."""

    since_s: float
    nodes: tuple[str, ...]
    infos: tuple[EndpointInfo, ...]


class GraphView:
    """The graph at one moment, in parts of the same age."""

    def __init__(self, parts: Iterable[GraphPart]) -> None:
        self.parts = tuple(parts)

    def nodes(self, since_s: float) -> Iterator[str]:
        for part in self.parts:
            if part.since_s >= since_s:
                yield from part.nodes

    def infos(self, topic: str, direction: Direction, since_s: float = 0.0) -> list[EndpointInfo]:
        mangled = f"{TOPIC}{topic}"
        return [
            info
            for part in self.parts
            if part.since_s >= since_s
            for info in part.infos
            if info.topic == mangled and info.direction == direction.value
        ]

    def publishers(self, topic: str) -> tuple[Endpoint, ...]:
        return tuple(info.endpoint() for info in self.infos(topic, Direction.PUBLISHER))

    def service_types(self, name: str, since_s: float = 0.0) -> list[str]:
        """The types of a service that a node offers; empty if there is none."""
        found = {
            ros_type(info.type, REQUEST)
            for part in self.parts
            if part.since_s >= since_s
            for info in part.infos
            if info.direction == Direction.SUBSCRIPTION.value
            and (known := ros_name(info.topic)) is not None
            and known == (REQUEST, name)
        }
        return sorted(found)


def followed(follower: DiscoveryFollower) -> GraphView:
    return GraphView(
        GraphPart(
            since_s=follower.since.get(peer.prefix, 0.0),
            nodes=tuple(node.name for node in peer.nodes()),
            infos=tuple(peer.infos()),
        )
        for peer in follower.participants
    )


class ObservedView:
    """Makes views of the graph of rclpy."""

    def __init__(self, observer: Observer) -> None:
        self.observer = observer
        self._since: dict[str, float] = {}

    def view(self) -> GraphView:
        snapshot = self.observer.graph_snapshot()
        now = time.monotonic()
        found = dict(_by_participant(snapshot))
        self._since = {key: self._since.get(key, now) for key in found}
        return GraphView(
            GraphPart(self._since[key], nodes, infos) for key, (nodes, infos) in found.items()
        )


def _by_participant(
    snapshot: GraphSnapshot,
) -> Iterator[tuple[str, tuple[tuple[str, ...], tuple[EndpointInfo, ...]]]]:
    """The nodes and endpoints of each participant; nodes without endpoints by their names."""
    infos: dict[str, list[EndpointInfo]] = {}
    for info in snapshot.infos:
        infos.setdefault(info.gid[:_PREFIX], []).append(info)
    living = [name for name in snapshot.nodes if name not in snapshot.ghosts]
    for key, some in infos.items():
        names = {info.node for info in some} & set(living)
        if names:
            yield key, (tuple(sorted(names)), tuple(some))
    owners = {info.node for info in snapshot.infos}
    for name in living:
        if name not in owners:
            yield name, ((name,), ())
