"""Scout: looks round by the wire while rclpy is being loaded, and introduces us to whom it met.

A participant of Fast DDS that has just come hears of the others by their answers, and it loses
those that come at once (see `nudge`); what it then asks for comes 0.1 s later. The scout has heard
all that. So it repeats it, word by word, to our participant as soon as there is one. What gets
lost on the way, DDS asks for as ever.

Who only listens is told of endpoints as well, and knows them after a few milliseconds. Who talks
is not: the others need their 0.1 s to know ours, and a service drops its answer to a client (and a
subscription a message of a publisher) that it does not know yet.
"""

from __future__ import annotations

import contextlib
import os
import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from launcher.ros.discovery import rtps
from launcher.ros.discovery.gids import sockets_of, widen_sockets
from launcher.ros.discovery.participant import Participant
from launcher.ros.discovery.ports import announcement_ports, socket_inodes
from launcher.ros.discovery.reader import DiscoveryReader, ReadResult, UnsupportedDiscovery
from launcher.ros.snapshot.graph import GraphSnapshot

# When endpoints are told, after the participant that has them: it has to be known by then.
_PAUSES_S = (0.003, 0.012)
_DATAGRAM_BYTES = 16 * 1024

Enough = Callable[[GraphSnapshot], object]


def never(look: GraphSnapshot) -> bool:
    """Go on looking until everybody has told everything."""
    return False


class Prefetch:
    """A look in a thread of its own; close it."""

    def __init__(
        self,
        domain_id: int,
        spin_time_s: float,
        *,
        remote: bool,
        enough: Enough = never,
        listens: bool = False,
    ) -> None:
        self._listens = listens
        self._domain_id = domain_id
        self._wire = DiscoveryReader(domain_id, remote=remote)
        self._seen: ReadResult | None = None
        self._closed = threading.Event()
        self._threads = [
            threading.Thread(target=self._look, args=(spin_time_s, enough), daemon=True)
        ]
        self._threads[0].start()

    def _look(self, spin_time_s: float, enough: Enough) -> None:
        # without a network, or where somebody speaks as only a whole DDS stack can, rclpy looks
        with contextlib.suppress(UnsupportedDiscovery, OSError), self._wire as wire:
            self._seen = wire.look(spin_time_s, enough=enough)

    def introduce(self) -> None:
        """Tell our participant, which has just come, of those that were met; returns at once."""
        self._threads.append(threading.Thread(target=self._introduce, daemon=True))
        self._threads[-1].start()

    def _introduce(self) -> None:
        widen_sockets(socket_inodes(self._domain_id))
        ports, held = announcement_ports(self._domain_id), sockets_of(os.getpid())
        own = {port for inode, port in ports.items() if inode in held}
        already = list(self._wire.met)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            self._hand_over(sender, own, already)
            self._threads[0].join()
            self._hand_over(sender, own, [peer for peer in self._wire.met if peer not in already])

    def _hand_over(self, sender: socket.socket, ports: set[int], peers: list[Participant]) -> None:
        def send(datagrams: Iterator[bytes]) -> None:
            for datagram in datagrams:
                for port in ports:
                    with contextlib.suppress(OSError):  # it has closed its port
                        sender.sendto(datagram, ("127.0.0.1", port))

        send(d for p in peers for d in _datagrams(p, [(rtps.SPDP_READER, p.announcement)]))
        for pause_s in _PAUSES_S if peers and self._listens else ():
            if self._closed.wait(pause_s):
                return
            send(d for p in peers for d in _datagrams(p, p.introductions()))

    def seen(self, own_participant: bytes) -> GraphSnapshot | None:
        """What there is without ourselves, as soon as that is known; None if it cannot be told."""
        self._threads[0].join()
        if self._seen is None:
            return None
        return _without(self._seen.look, own_participant.hex("."))

    def close(self) -> None:
        """End the look, and be forgotten."""
        self._closed.set()
        self._wire.stop()
        for thread in self._threads:
            thread.join()


def _datagrams(peer: Participant, told: Iterable[tuple[bytes, rtps.Data]]) -> Iterator[bytes]:
    """What a participant has told, in datagrams that look like its own."""
    body = b""
    for reader, sample in told:
        part = rtps.repeated(reader, sample)
        if body and len(body) + len(part) > _DATAGRAM_BYTES:
            yield rtps.message(peer.prefix, peer.prefix[:2], body)
            body = b""
        body += part
    if body:
        yield rtps.message(peer.prefix, peer.prefix[:2], body)


def _without(look: GraphSnapshot, participant: str) -> GraphSnapshot:
    """The look without the nodes and endpoints of a participant (which all looks leave out)."""
    if not participant:
        return look
    own = {info.node for info in look.infos if info.gid.startswith(participant)}
    return replace(
        look,
        nodes=tuple(node for node in look.nodes if node not in own),
        infos=tuple(info for info in look.infos if not info.gid.startswith(participant)),
    )
