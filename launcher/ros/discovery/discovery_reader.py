"""Reads a ROS graph from the discovery messages of DDS (RTPS), without a DDS stack.

A stack is slow at this one task: it announces itself before it listens, so answers are lost and
come again with the next announcement, up to 3 s later. Here a socket listens first, then asks each
participant of this machine at its port. They answer at once, with the number of their endpoints (a
heartbeat), so that the reader sees when the graph is complete. At its end it disposes of its
announcement, so that the others forget it.

With 20 participants `topic list`, `node list`, `topic info -v` and `graph` take 0.32 to 0.35 s (by
rclpy 2.1 to 2.4 s), beside two busy loops 0.5 to 0.7 s (2.3 to 3.3 s, and as few as 18 of them);
all 48 runs were complete.
"""

from __future__ import annotations

import contextlib
import math
import select
import socket
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launcher.posix.domains import REMOTE_S
from launcher.posix.ports import multicast_port, occupied_ports
from launcher.ros.discovery import rtps
from launcher.ros.discovery.endpoints import NODES_TOPIC, NODES_TYPE, NODES_TYPE_HASH
from launcher.ros.discovery.participant import OWN_READER, Participant, SampleStream, snapshot_of
from launcher.ros.snapshot.ros_graph import GraphSnapshot

if TYPE_CHECKING:
    from typing_extensions import Self

_REMOTE_LATEST_S = 1.5  # other machines that are not complete by then are not waited for
_STEADY_S = 0.06  # all samples of one participant arrive within that
_ANNOUNCE_S = 0.1
_DISPOSE_S = 0.3  # dispose there: a participant that has discovered us does not answer again
_REPEAT_S = 0.25  # Fast DDS answers 0.1 s after a request
_LEASE_S = 10
_GROUP = "239.255.0.1"
_BUFFER_BYTES = 4 << 20
# writes participants and subscriptions; reads participants, publications, subscriptions
_ENDPOINT_SET = 0b111011


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadResult:
    """A snapshot; `missing` participants of this machine are not, or only partly, in it."""

    snapshot: GraphSnapshot
    missing: int
    waited_s: float


class UnsupportedDiscovery(Exception):
    """A participant uses a part of RTPS that only a whole DDS stack implements."""


def read_graph(domain_id: int, spin_time_s: float, *, remote: bool) -> ReadResult:
    """Read a domain, for at most `spin_time_s`; `remote`: on other machines as well.

    Raises UnsupportedDiscovery, and OSError where there is no network at all.
    """
    with DiscoveryReader(domain_id, remote=remote) as reader:
        return reader.read(spin_time_s)


class DiscoveryReader:
    """A participant that only requests what others announce; use it in a `with` statement."""

    def __init__(self, domain_id: int, *, remote: bool) -> None:
        self._domain_id = domain_id
        self._remote = remote
        self._prefix = rtps.new_prefix()
        self._peers: dict[bytes, Participant] = {}
        self.discovered: list[Participant] = []  # another thread may read it
        self._number = self._count = 0
        self._is_stopped = False

    def __enter__(self) -> Self:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        self._socket.bind(("0.0.0.0" if self._remote else "127.0.0.1", 0))
        self._socket.setblocking(False)
        return self

    def __exit__(self, *exit_info: object) -> None:
        self._dispose({peer.address for peer in self._peers.values()} | self._addresses(set()))
        self._socket.close()

    def read(
        self, spin_time_s: float, *, enough: Callable[[GraphSnapshot], object] = lambda graph: False
    ) -> ReadResult:
        """Request until the graph is complete, or `enough`, or `stop`; at most `spin_time_s`.

        `enough` is called whenever nothing new has arrived for a moment.
        """
        start = time.monotonic()
        end = start + spin_time_s
        shortest = start + min(spin_time_s, REMOTE_S if self._remote else 0.0)
        expected = occupied_ports(self._domain_id)
        announce, dispose_at = start, start + _DISPOSE_S
        samples, steady = -1, start
        while True:
            now = time.monotonic()
            silent = self._silent(expected)
            complete = self._is_complete(remote=now - start < _REMOTE_LATEST_S)
            if self._is_stopped or now >= end or (now >= shortest and complete and not silent):
                break
            # changes with every participant and every sample
            arrived = len(self._peers) + sum(peer.arrived for peer in self._peers.values())
            if arrived != samples:
                samples, steady = arrived, now + _STEADY_S
            elif now >= steady:
                steady = math.inf
                if enough(self._known()):
                    break
            if now >= announce:
                expected &= occupied_ports(self._domain_id)
                if now >= dispose_at:
                    self._dispose({("127.0.0.1", port) for port in silent})
                    dispose_at = now + 2 * (now - start)
                self._announce(self._addresses(silent))
                announce = now + _ANNOUNCE_S
            self._repeat_requests(now)
            self._receive(min(end, announce, steady) - now)
        incomplete = {peer.port for peer in self._peers.values() if not peer.is_complete}
        return ReadResult(
            snapshot=self._known(),
            missing=len(self._silent(expected) | (expected & incomplete)),
            waited_s=now - start,
        )

    @property
    def participants(self) -> list[Participant]:
        """Those that are there."""
        return list(self._peers.values())

    def stop(self) -> None:
        """End `read` soon; may be called from another thread."""
        self._is_stopped = True

    def _known(self) -> GraphSnapshot:
        return snapshot_of(self._domain_id, self._peers.values())

    def _silent(self, expected: set[int]) -> set[int]:
        return expected - {peer.port for peer in self._peers.values() if peer.is_local}

    def _is_complete(self, *, remote: bool) -> bool:
        """Whether all are complete; `remote`: those on other machines as well."""
        peers = [peer for peer in self._peers.values() if peer.is_local or remote]
        return all(peer.is_complete for peer in peers)

    def _addresses(self, silent: set[int]) -> set[tuple[str, int]]:
        group = {(_GROUP, multicast_port(self._domain_id))} if self._remote else set()
        return group | {("127.0.0.1", port) for port in silent}

    # sending

    def _announce(self, addresses: set[tuple[str, int]]) -> None:
        self._number += 1
        locators = [rtps.locator(host, self._port) for host in self._hosts()]
        announcement = rtps.announcement(
            self._prefix, self._number, locators, endpoints=_ENDPOINT_SET, lease_s=_LEASE_S
        )
        for address in sorted(addresses):
            self._send(address, announcement)

    def _dispose(self, addresses: set[tuple[str, int]]) -> None:
        self._number += 1
        gone = rtps.end_of_participant(self._prefix, self._number)
        for address in sorted(addresses):
            self._send(address, gone)

    @property
    def _port(self) -> int:
        return int(self._socket.getsockname()[1])

    def _hosts(self) -> list[str]:
        hosts = ["127.0.0.1"]
        if self._remote:
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                try:
                    probe.connect((_GROUP, 9))
                except OSError:
                    return hosts  # no route to other machines
                hosts.append(probe.getsockname()[0])
        return hosts

    def _subscribe(self, peer: Participant) -> None:
        """Subscribe to the topic on which a participant publishes its nodes."""
        listed = [
            (0x5A, self._prefix + OWN_READER),
            *((0x2F, rtps.locator(host, self._port)) for host in self._hosts()),
            (0x50, self._prefix + rtps.PARTICIPANT),
            (0x05, rtps.text(NODES_TOPIC)),
            (0x07, rtps.text(NODES_TYPE)),
            (0x70, self._prefix + OWN_READER),
            (0x1D, struct.pack("<I", 1)),  # transient local
            (0x1A, struct.pack("<IiI", 2, 0, 0x1999999A)),  # reliable
            (0x2C, rtps.text(f"typehash={NODES_TYPE_HASH};").rstrip(b"\0")),
        ]
        reader, writer = rtps.SUBSCRIPTIONS_READER, rtps.SUBSCRIPTIONS_WRITER
        self._count += 1
        self._send(
            peer.address,
            rtps.to(peer.prefix),
            rtps.sample(reader, writer, 1, listed),
            rtps.heartbeat(reader, writer, 1, self._count),
        )

    def _request(self, peer: Participant, stream: SampleStream, now: float) -> None:
        if not (missing := stream.missing()):
            return
        stream.requested_s = now
        stream.requested_to = max(n for n in missing if n - missing[0] < rtps.WINDOW)
        self._count += 1
        address = peer.address if stream.reader != OWN_READER else peer.data_address
        request = rtps.ask(stream.reader, stream.writer, missing, self._count)
        self._send(address, rtps.to(peer.prefix), request)

    def _repeat_requests(self, now: float) -> None:
        for peer in self._peers.values():
            for stream in peer.streams():
                if now - stream.requested_s >= _REPEAT_S:
                    self._request(peer, stream, now)

    def _send(self, address: tuple[str, int], *submessages: bytes) -> None:
        with contextlib.suppress(OSError):  # no such port any more, no route
            self._socket.sendto(
                rtps.message(self._prefix, rtps.UNKNOWN_VENDOR, *submessages), address
            )

    # receiving

    def _receive(self, timeout_s: float) -> None:
        """Take all datagrams that are there, after a wait for the first."""
        select.select([self._socket], [], [], max(0.0, timeout_s))
        while True:
            try:
                datagram, sender = self._socket.recvfrom(65536)
            except BlockingIOError:
                return
            try:
                for part in rtps.parts(datagram, self._prefix):
                    self._take(part, sender[0])
            except ValueError:
                continue  # malformed

    def _take(self, part: rtps.Part, host: str) -> None:
        if isinstance(part, rtps.AckNack):
            asker = self._peers.get(part.reader[: rtps.PREFIX_BYTES])
            if asker and part.writer_entity == rtps.SUBSCRIPTIONS_WRITER:
                self._subscribe(asker)
            return
        prefix, entity = part.writer[: rtps.PREFIX_BYTES], part.writer[rtps.PREFIX_BYTES :]
        if isinstance(part, rtps.Data) and entity == rtps.SPDP_WRITER:
            self._add_peer(part, prefix, host)
        elif (peer := self._peers.get(prefix)) and (stream := peer.stream(entity)):
            if isinstance(part, rtps.Fragment):
                raise UnsupportedDiscovery
            stream.take(part)
            now = time.monotonic()
            is_due = isinstance(part, rtps.Heartbeat) and now - stream.requested_s > _REPEAT_S
            # all samples of one request have arrived, and there are more
            if is_due or (isinstance(part, rtps.Data) and part.number == stream.requested_to):
                self._request(peer, stream, now)

    def _add_peer(self, data: rtps.Data, prefix: bytes, host: str) -> None:
        if data.gone:
            self._peers.pop(prefix, None)
        elif prefix not in self._peers and prefix != self._prefix:
            # participants of this machine may answer from any of its addresses
            near = host in self._hosts() or host.startswith("127.")
            where = "127.0.0.1" if near else host
            peer = self._peers[prefix] = Participant(prefix, data, where)
            self.discovered.append(peer)
            self._subscribe(peer)
