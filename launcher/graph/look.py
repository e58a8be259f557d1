"""Look: a ROS graph at one moment as plain data, whoever has looked, and what verbs ask of it.

rclpy (`observer`), the discovery messages themselves (`wire`) and the observer of a run (`ask`)
give the same; nothing here imports rclpy.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from launcher.graph.mangling import ros_name, ros_type
from launcher.graph.snapshot import INFINITE_NS, Direction, Endpoint, Snapshot

UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"  # an endpoint whose participant has not said so yet
UNKNOWN_NAMESPACE = "_NODE_NAMESPACE_UNKNOWN_"
TOPIC, REQUEST, REPLY = "rt", "rq", "rr"
_FEEDBACK, _FEEDBACK_TYPE = "/_action/feedback", "_FeedbackMessage"

NamesAndTypes = list[tuple[str, list[str]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Info:
    """An endpoint as DDS names it: `topic` and `type` mangled, `node` a full name or empty."""

    topic: str
    type: str
    node: str
    direction: str
    reliability: str
    durability: str
    liveliness: str = "AUTOMATIC"
    deadline_ns: int = INFINITE_NS
    lease_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    type_hash: str = "INVALID"
    gid: str = ""

    @property
    def node_name(self) -> str:
        """The last part of the node's name."""
        return self.node.rpartition("/")[2] or UNKNOWN_NODE

    @property
    def node_namespace(self) -> str:
        """What is before it."""
        if not self.node:
            return UNKNOWN_NAMESPACE
        return self.node.rpartition("/")[0] or "/"

    def endpoint(self) -> Endpoint:
        """The same with ROS's names."""
        name = ros_name(self.topic)
        return Endpoint(
            topic=name.name if name else self.topic,
            node=self.node or f"{UNKNOWN_NAMESPACE}/{UNKNOWN_NODE}",
            direction=self.direction,
            type=ros_type(self.type, name.channel if name else TOPIC),
            reliability=self.reliability,
            durability=self.durability,
            liveliness=self.liveliness,
            deadline_ns=self.deadline_ns,
            lease_ns=self.lease_ns,
            gid=self.gid,
        )

    def __str__(self) -> str:
        """As rclpy's TopicEndpointInfo, which ros2cli prints."""
        lines = {
            "Node name": self.node_name,
            "Node namespace": self.node_namespace,
            "Topic type": ros_type(self.type),
            "Topic type hash": self.type_hash,
            "Endpoint type": self.direction.upper(),
            "GID": self.gid,
            "QoS profile": "",
            "  Reliability": self.reliability,
            "  History (Depth)": "UNKNOWN",  # discovery does not carry it
            "  Durability": self.durability,
            "  Lifespan": _duration(self.lifespan_ns),
            "  Deadline": _duration(self.deadline_ns),
            "  Liveliness": self.liveliness,
            "  Liveliness lease duration": _duration(self.lease_ns),
        }
        return "\n".join(f"{title}: {value}".rstrip() for title, value in lines.items())


def _duration(nanoseconds: int) -> str:
    return "Infinite" if nanoseconds >= INFINITE_NS else f"{nanoseconds} nanoseconds"


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Nodes (full names, sorted, twice if two share one), every endpoint, and `ghosts`.

    Ghosts are nodes whose process is gone. What belongs to the one who looked is left out.
    """

    domain_id: int
    nodes: tuple[str, ...]
    infos: tuple[Info, ...]
    ghosts: tuple[str, ...] = ()

    def topic_types(self) -> dict[str, list[str]]:
        """Every topic and its types."""
        return _types_by_name(self.infos, (TOPIC,))

    def service_types(self) -> dict[str, list[str]]:
        """Every service and its types, that somebody only calls, too."""
        return _types_by_name(self.infos, (REQUEST, REPLY))

    def on(self, topic: str, direction: Direction) -> list[Info]:
        """The publishers or subscriptions of a topic."""
        mangled = f"{TOPIC}{topic}"
        return [i for i in self.infos if i.topic == mangled and i.direction == direction.value]

    def endpoints(self, topic: str) -> list[Endpoint]:
        """The endpoints of a topic, publishers first."""
        return [info.endpoint() for direction in Direction for info in self.on(topic, direction)]

    def of_node(self, node: str) -> dict[str, NamesAndTypes]:
        """Title -> names and types, in the order of `ros2 node info`, hidden ones as well."""
        own = [info for info in self.infos if info.node == node]
        reading = [i for i in own if i.direction == Direction.SUBSCRIPTION.value]
        writing = [i for i in own if i.direction == Direction.PUBLISHER.value]
        heard, said = _types_by_name(reading, (TOPIC,)), _types_by_name(writing, (TOPIC,))
        return {
            "Subscribers": sorted(heard.items()),
            "Publishers": sorted(said.items()),
            "Service Servers": sorted(_types_by_name(reading, (REQUEST,)).items()),
            "Service Clients": sorted(_types_by_name(reading, (REPLY,)).items()),
            "Action Servers": _actions(said),
            "Action Clients": _actions(heard),
        }

    def snapshot(self) -> Snapshot:
        """The topics of nodes that are known, as pictures and comparisons take them."""
        topics = [i for i in self.infos if i.topic.startswith(f"{TOPIC}/") and i.node]
        endpoints = tuple(sorted(info.endpoint() for info in topics))
        return Snapshot(nodes=self.nodes, endpoints=endpoints, ghosts=self.ghosts)

    def to_document(self) -> dict[str, Any]:
        """The look as JSON can carry it."""
        return {
            "domain_id": self.domain_id,
            "nodes": list(self.nodes),
            "infos": [asdict(info) for info in self.infos],
            "ghosts": list(self.ghosts),
        }


def from_document(document: Mapping[str, Any]) -> Look:
    """What `to_document` gave; KeyError or TypeError for something else."""
    return Look(
        domain_id=int(document["domain_id"]),
        nodes=tuple(document["nodes"]),
        infos=tuple(Info(**info) for info in document["infos"]),
        ghosts=tuple(document["ghosts"]),
    )


def _types_by_name(infos: Iterable[Info], channels: tuple[str, ...]) -> dict[str, list[str]]:
    found: dict[str, set[str]] = {}
    for info in infos:
        name = ros_name(info.topic)
        if name and name.channel in channels:
            found.setdefault(name.name, set()).add(ros_type(info.type, name.channel))
    return {name: sorted(types) for name, types in sorted(found.items())}


def _actions(topics: Mapping[str, list[str]]) -> NamesAndTypes:
    """The actions behind topics of feedback."""
    return [
        (name.removesuffix(_FEEDBACK), [t.removesuffix(_FEEDBACK_TYPE) for t in types])
        for name, types in sorted(topics.items())
        if name.endswith(_FEEDBACK)
    ]
