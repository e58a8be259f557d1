"""The clients and servers of a service, each of which reads one topic of DDS and writes another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.gids import participant_of
from launcher.ros.snapshot.ros_graph import (
    REPLY,
    REQUEST,
    EndpointInfo,
    GraphSnapshot,
    ros_name,
    ros_type,
)
from launcher.ros.topics.listing import endpoint_document

_NO_HASH = "INVALID"  # as rclpy prints it


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceEndpoint:
    """A client or a server; without a `writer` until that is discovered, too."""

    reader: EndpointInfo
    writer: EndpointInfo | None

    @property
    def is_client(self) -> bool:
        return self.reader.topic.startswith(f"{REPLY}/")

    @property
    def type(self) -> str:
        return ros_type(self.reader.type, REPLY if self.is_client else REQUEST)

    def type_hash(self) -> str:
        """Of the service. DDS announces that of the message; the same one has to be installed."""
        from launcher.ros.messages.message_schema import rihs_hash

        message = f"{self.type}_{'Response' if self.is_client else 'Request'}"
        try:
            is_same = rihs_hash(message) == self.reader.type_hash
            return rihs_hash(self.type) if is_same else _NO_HASH
        except VerbError:
            return _NO_HASH

    def parts(self) -> dict[str, EndpointInfo]:
        """What ROS calls the endpoints of DDS, in its order."""
        reader = {"Response Reader" if self.is_client else "Request Reader": self.reader}
        if self.writer is None:
            return reader
        if self.is_client:
            return {"Request Writer": self.writer, **reader}
        return {**reader, "Response Writer": self.writer}

    def lines(self) -> Iterator[str]:
        """The same as of rclpy's ServiceEndpointInfo, which ros2cli prints."""
        parts = self.parts()
        yield f"Node name: {self.reader.node_name}"
        yield f"Node namespace: {self.reader.node_namespace}"
        yield f"Service type: {self.type}"
        yield f"Service type hash: {self.type_hash()}"
        yield f"Endpoint type: {'CLIENT' if self.is_client else 'SERVER'}"
        yield f"Endpoint count: {len(parts)}"
        if len(parts) == 1:
            yield f"GID: {self.reader.gid}"
            yield "QoS profile:"
            yield from self.reader.qos_lines()
            return
        yield "GIDs:"
        yield from (f" - {title} : {info.gid}" for title, info in parts.items())
        yield "QoS profiles:"
        for title, info in parts.items():
            yield f" - {title} :"
            yield from info.qos_lines(indent="      ")

    def document(self) -> dict[str, Any]:
        documents = {
            title.lower().replace(" ", "_"): endpoint_document(info)
            for title, info in self.parts().items()
        }
        for one in documents.values():
            del one["node"], one["direction"], one["type"]
        role = "client" if self.is_client else "server"
        node = self.reader.endpoint().node
        return {"node": node, "role": role, "type_hash": self.type_hash(), **documents}


def endpoints(graph: GraphSnapshot, service: str) -> list[ServiceEndpoint]:
    """The clients, then the servers, each sorted by node."""
    found = [graph.clients(service), graph.servers(service)]
    return [one for readers in found for one in _paired(graph, readers)]


def _paired(graph: GraphSnapshot, readers: list[EndpointInfo]) -> Iterator[ServiceEndpoint]:
    """Each reader with its writer. A node makes both, one after the other, so that with several
    clients of one service in a node the first belongs to the first.
    """
    left = sorted((i for i in graph.infos if i.is_publisher), key=lambda info: info.gid)
    for reader in sorted(readers, key=lambda info: (info.node, info.gid)):
        name = ros_name(reader.topic)
        assert name is not None
        topic = f"{REPLY}{name.name}Reply"
        if name.channel == REPLY:
            topic = f"{REQUEST}{name.name}Request"
        owner = participant_of(reader.gid), reader.node
        own = [i for i in left if i.topic == topic and (participant_of(i.gid), i.node) == owner]
        if own:
            left.remove(own[0])
        yield ServiceEndpoint(reader=reader, writer=own[0] if own else None)


def info_lines(found: list[ServiceEndpoint], types: list[str], *, verbose: bool) -> Iterator[str]:
    """The lines of `service info`, as ros2cli prints them."""
    yield f"Type: {types[0] if len(types) == 1 else types}"
    for title, is_client in (("Clients", True), ("Services", False)):
        own = [one for one in found if one.is_client == is_client]
        yield f"{title} count: {len(own)}"
        if verbose:
            for one in own:
                yield from (*one.lines(), "")
