"""A ROS graph at one moment, as plain data.

`GraphSnapshot` is all that was discovered, by whichever way of `discovery`; `TopicGraph` is the
part that is drawn and compared.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

# topics of every node
DEBUG_TOPICS = frozenset({"/rosout", "/parameter_events"})
# The services that every node has, below its name, with their types.
NODE_SERVICES = {
    "describe_parameters": "rcl_interfaces/srv/DescribeParameters",
    "get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
    "get_parameters": "rcl_interfaces/srv/GetParameters",
    "get_type_description": "type_description_interfaces/srv/GetTypeDescription",
    "list_parameters": "rcl_interfaces/srv/ListParameters",
    "set_parameters": "rcl_interfaces/srv/SetParameters",
    "set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
}

INFINITE_NS = 2**63 - 1

UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"  # as in rclpy
UNKNOWN_HISTORY = "UNKNOWN"
UNKNOWN_NAMESPACE = "_NODE_NAMESPACE_UNKNOWN_"
TOPIC, REQUEST, REPLY = "rt", "rq", "rr"
_STATE_TYPE = "lifecycle_msgs/srv/GetState"
_FEEDBACK, _FEEDBACK_TYPE = "/_action/feedback", "_FeedbackMessage"

NamesAndTypes = list[tuple[str, list[str]]]


class Direction(enum.Enum):
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
        return self.direction == Direction.PUBLISHER.value

    @property
    def has_name(self) -> bool:
        return not self.node.endswith(UNKNOWN_NODE)

    @property
    def shown_node(self) -> str:
        """The name of its node for a sentence."""
        return self.node if self.has_name else "a node whose name is not known yet"


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicGraph:
    """Nodes (full names, twice if two share one) and endpoints, sorted.

    `ghosts` are the nodes whose process has ended and that discovery has not dropped yet.
    """

    nodes: tuple[str, ...]
    endpoints: tuple[Endpoint, ...]
    ghosts: tuple[str, ...] = ()

    def without(self, topics: Iterable[str]) -> TopicGraph:
        hidden = frozenset(topics)
        kept = tuple(e for e in self.endpoints if e.topic not in hidden)
        return replace(self, endpoints=kept)

    def topics(self) -> tuple[str, ...]:
        return tuple(sorted({e.topic for e in self.endpoints}))

    def on(self, topic: str) -> tuple[Endpoint, ...]:
        return tuple(e for e in self.endpoints if e.topic == topic)


def is_node_service(name: str, types: Iterable[str]) -> bool:
    """Whether a service with these types is one that every node has."""
    return {*types} == {NODE_SERVICES.get(name.rpartition("/")[2])}


def is_hidden(name: str) -> bool:
    """Whether a part of the name begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))


class RosName(NamedTuple):
    """A name in ROS; the channel is `rt` for topics, `rq` and `rr` for requests and replies."""

    channel: str
    name: str


def ros_name(topic: str) -> RosName | None:
    """The name in ROS of `rt/chatter` or `rq/switchRequest`; None for other names of DDS."""
    channel, slash, name = topic.partition("/")
    if not slash or channel not in (TOPIC, REQUEST, REPLY):
        return None
    ending = {REQUEST: "Request", REPLY: "Reply"}.get(channel, "")
    return RosName(channel, "/" + name.removesuffix(ending))


def ros_type(type_name: str, channel: str = TOPIC) -> str:
    """`std_msgs::msg::dds_::String_` -> `std_msgs/msg/String`; other types of DDS as they are."""
    if "::dds_::" not in type_name or not type_name.endswith("_"):
        return type_name
    plain = type_name.replace("::dds_::", "::")[:-1].replace("::", "/")
    if channel == TOPIC:
        return plain
    return plain.removesuffix("_Request").removesuffix("_Response")


@dataclass(frozen=True, slots=True, kw_only=True)
class EndpointInfo(Endpoint):
    """An endpoint as DDS names it: `topic` and `type` mangled; `node` is empty if unknown.

    `history` is as in `shown_history`; most middleware does not announce it.
    """

    lifespan_ns: int = INFINITE_NS
    type_hash: str = "INVALID"
    history: str = UNKNOWN_HISTORY

    @property
    def node_name(self) -> str:
        return self.node.rpartition("/")[2] or UNKNOWN_NODE

    @property
    def node_namespace(self) -> str:
        if not self.node:
            return UNKNOWN_NAMESPACE
        return self.node.rpartition("/")[0] or "/"

    def endpoint(self) -> Endpoint:
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
        """The same as of rclpy's TopicEndpointInfo, which ros2cli prints."""
        lines = {
            "Node name": self.node_name,
            "Node namespace": self.node_namespace,
            "Topic type": ros_type(self.type),
            "Topic type hash": self.type_hash,
            "Endpoint type": self.direction.upper(),
            "GID": self.gid,
        }
        head = (f"{title}: {value}" for title, value in lines.items())
        return "\n".join([*head, "QoS profile:", *self.qos_lines()])

    def qos_lines(self, indent: str = "  ") -> list[str]:
        lines = {
            "Reliability": self.reliability,
            "History (Depth)": self.history,
            "Durability": self.durability,
            "Lifespan": _duration(self.lifespan_ns),
            "Deadline": _duration(self.deadline_ns),
            "Liveliness": self.liveliness,
            "Liveliness lease duration": _duration(self.lease_ns),
        }
        return [f"{indent}{title}: {value}" for title, value in lines.items()]


def shown_history(name: str, depth: int) -> str:
    """`KEEP_LAST (10)`, `KEEP_ALL` or `UNKNOWN`, as rclpy writes it."""
    return f"{name} ({depth})" if name == "KEEP_LAST" else name


def _duration(nanoseconds: int) -> str:
    return "Infinite" if nanoseconds >= INFINITE_NS else f"{nanoseconds} nanoseconds"


@dataclass(frozen=True, slots=True, kw_only=True)
class GraphSnapshot:
    """Nodes (full names, sorted, twice if two share one), every endpoint, and `ghosts`.

    Ghosts are nodes whose process has ended. The observer itself is left out.
    """

    domain_id: int
    nodes: tuple[str, ...]
    infos: tuple[EndpointInfo, ...]
    ghosts: tuple[str, ...] = ()

    def topic_types(self) -> dict[str, list[str]]:
        return _types_by_name(self.infos, (TOPIC,))

    def service_types(self) -> dict[str, list[str]]:
        """Every service and its types, including those that have clients only."""
        return _types_by_name(self.infos, (REQUEST, REPLY))

    def servers(self, service: str) -> list[EndpointInfo]:
        """What reads the requests of a service."""
        return self._reading(f"{REQUEST}{service}Request")

    def clients(self, service: str) -> list[EndpointInfo]:
        """What reads the replies of a service."""
        return self._reading(f"{REPLY}{service}Reply")

    def _reading(self, mangled: str) -> list[EndpointInfo]:
        direction = Direction.SUBSCRIPTION.value
        return [i for i in self.infos if i.topic == mangled and i.direction == direction]

    def is_lifecycle(self, node: str) -> bool:
        """Whether a node is there and has the service for its state."""
        servers = self.servers(f"{node}/get_state")
        # a participant announces its services before its nodes
        return node in self.nodes and any(
            ros_type(one.type, REQUEST) == _STATE_TYPE for one in servers
        )

    def lifecycle_nodes(self) -> list[str]:
        """Full names, sorted."""
        return [node for node in sorted(set(self.nodes)) if self.is_lifecycle(node)]

    def action_types(self) -> dict[str, list[str]]:
        """Every action and its types, including those that have clients only."""
        return dict(_actions(self.topic_types()))

    def on(self, topic: str, direction: Direction) -> list[EndpointInfo]:
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
        read, written = _types_by_name(reading, (TOPIC,)), _types_by_name(writing, (TOPIC,))
        return {
            "Subscribers": sorted(read.items()),
            "Publishers": sorted(written.items()),
            "Service Servers": sorted(_types_by_name(reading, (REQUEST,)).items()),
            "Service Clients": sorted(_types_by_name(reading, (REPLY,)).items()),
            "Action Servers": _actions(written),
            "Action Clients": _actions(read),
        }

    def topic_graph(self) -> TopicGraph:
        """The endpoints of topics whose node is known."""
        topics = [i for i in self.infos if i.topic.startswith(f"{TOPIC}/") and i.node]
        endpoints = tuple(sorted(info.endpoint() for info in topics))
        return TopicGraph(nodes=self.nodes, endpoints=endpoints, ghosts=self.ghosts)

    def to_document(self) -> dict[str, Any]:
        return asdict(self)


def from_document(document: Mapping[str, Any]) -> GraphSnapshot:
    """What `to_document` gave; KeyError or TypeError for something else."""
    return GraphSnapshot(
        domain_id=int(document["domain_id"]),
        nodes=tuple(document["nodes"]),
        infos=tuple(EndpointInfo(**info) for info in document["infos"]),
        ghosts=tuple(document["ghosts"]),
    )


def _types_by_name(
    infos: Iterable[EndpointInfo], channels: tuple[str, ...]
) -> dict[str, list[str]]:
    found: dict[str, set[str]] = {}
    for info in infos:
        name = ros_name(info.topic)
        if name and name.channel in channels:
            found.setdefault(name.name, set()).add(ros_type(info.type, name.channel))
    return {name: sorted(types) for name, types in sorted(found.items())}


def _actions(topics: Mapping[str, list[str]]) -> NamesAndTypes:
    return [
        (name.removesuffix(_FEEDBACK), [t.removesuffix(_FEEDBACK_TYPE) for t in types])
        for name, types in sorted(topics.items())
        if name.endswith(_FEEDBACK)
    ]
