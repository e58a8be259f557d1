"""A participant that the reader has discovered, and which of its samples have arrived."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

from launcher.ros.discovery import endpoints, rtps
from launcher.ros.snapshot.ros_graph import Direction, EndpointInfo, GraphSnapshot

OWN_READER = bytes.fromhex("00000104")  # of NODES_TOPIC
_USER_WRITERS = (0x02, 0x03)  # kinds of entity
# Bits of the set of built-in endpoints.
_HAS_PUBLICATIONS, _HAS_SUBSCRIPTIONS = 1 << 2, 1 << 4


class SampleStream:
    """The samples of one writer, by sequence number."""

    def __init__(self, writer: bytes, reader: bytes) -> None:
        self.writer = writer
        self.reader = reader
        self.requested_s = -math.inf  # monotonic time of our last request
        self.requested_to = 0  # the highest number in it
        self.samples: dict[int, rtps.Data] = {}
        self._gone: set[int] = set()
        self._first, self._last = 1, -1

    def take(self, part: rtps.Part) -> None:
        if isinstance(part, rtps.Data):
            self.samples[part.number] = part
        elif isinstance(part, rtps.Gap):
            self._gone |= part.numbers
        elif isinstance(part, rtps.Heartbeat) and part.last >= self._last:
            self._first, self._last = part.first, part.last

    def missing(self) -> list[int]:
        """The samples that the writer holds and that have not arrived, sorted."""
        known = self.samples.keys() | self._gone
        return [n for n in range(self._first, self._last + 1) if n not in known]

    @property
    def is_complete(self) -> bool:
        """Whether the writer has announced its samples, and all of them have arrived."""
        return self._last >= 0 and not self.missing()

    def in_order(self) -> Iterator[rtps.Data]:
        return (self.samples[number] for number in sorted(self.samples))


class Participant:
    """A participant; `host` is the sender of its announcement."""

    def __init__(self, prefix: bytes, announcement: rtps.Data, host: str) -> None:
        metatraffic, data, builtin = endpoints.contact_in(announcement.payload)
        self.announcement = announcement
        self.prefix = prefix
        self.is_local = host.startswith("127.")
        self.port = metatraffic
        self.address = (host, metatraffic)
        self.data_address = (host, data)
        self._publications = SampleStream(rtps.PUBLICATIONS_WRITER, rtps.PUBLICATIONS_READER)
        self._subscriptions = SampleStream(rtps.SUBSCRIPTIONS_WRITER, rtps.SUBSCRIPTIONS_READER)
        self._nodes: SampleStream | None = None
        self._expected = [
            stream
            for stream, bit in (
                (self._publications, _HAS_PUBLICATIONS),
                (self._subscriptions, _HAS_SUBSCRIPTIONS),
            )
            if builtin is None or builtin & bit
        ]

    def introductions(self) -> Iterator[tuple[bytes, rtps.Data]]:
        """Reader and sample of each endpoint; may be called from another thread."""
        for stream in self._expected:
            samples = list(stream.samples.values())
            yield from ((stream.reader, sample) for sample in samples if sample.payload)

    @property
    def arrived(self) -> int:
        return sum(len(stream.samples) for stream in self.streams())

    def streams(self) -> list[SampleStream]:
        return [*self._expected, *([self._nodes] if self._nodes else [])]

    def stream(self, entity: bytes) -> SampleStream | None:
        """The samples of one of its writers; None if we do not read them."""
        for stream in self.streams():
            if stream.writer == entity:
                return stream
        if entity[3] in _USER_WRITERS and self._nodes is None:
            # the only topic that we subscribe to
            self._nodes = SampleStream(entity, OWN_READER)
        return self._nodes if self._nodes and self._nodes.writer == entity else None

    @property
    def is_complete(self) -> bool:
        """Whether all its endpoints have arrived and, if it is one of ROS, its nodes."""
        if not all(stream.is_complete for stream in self._expected):
            return False
        if self._nodes is not None:
            return self._nodes.is_complete
        return all(info.topic != endpoints.NODES_TOPIC for info in self._endpoints())

    def _endpoints(self) -> list[EndpointInfo]:
        return [
            *_endpoints(self._publications, Direction.PUBLISHER),
            *_endpoints(self._subscriptions, Direction.SUBSCRIPTION),
        ]

    def nodes(self) -> tuple[endpoints.NodeEndpoints, ...]:
        """Its nodes; each sample contains all of them."""
        samples = list(self._nodes.in_order()) if self._nodes else []
        try:
            return endpoints.nodes_in(samples[-1].payload) if samples else ()
        except ValueError:
            return ()  # not a participant of ROS

    def infos(self) -> list[EndpointInfo]:
        """Its endpoints with the names of their nodes."""
        owners = {gid.hex("."): node.name for node in self.nodes() for gid in node.gids}
        return [replace(info, node=owners.get(info.gid, "")) for info in self._endpoints()]


def _endpoints(stream: SampleStream, direction: Direction) -> list[EndpointInfo]:
    found: dict[str, EndpointInfo] = {}
    for data in stream.in_order():
        if data.gone:
            found.pop(endpoints.gone_guid(data).hex("."), None)
        else:
            with contextlib.suppress(ValueError):  # malformed, so not of ROS
                info = endpoints.endpoint_in(data.payload, direction)
                found[info.gid] = info
    return list(found.values())


def snapshot_of(domain_id: int, peers: Iterable[Participant]) -> GraphSnapshot:
    """The graph of these participants; endpoints sorted by topic, node and direction."""
    peers = list(peers)
    infos = [info for peer in peers for info in peer.infos()]
    return GraphSnapshot(
        domain_id=domain_id,
        nodes=tuple(sorted(node.name for peer in peers for node in peer.nodes())),
        infos=tuple(sorted(infos, key=lambda i: (i.topic, i.node, i.direction, i.gid))),
    )
