"""`python -m tests.support.hosts.relay IF1 IF2 DELAY_S LOSS BYTES_PER_S`: a slow line between two.

Packets of each interface leave by the other one, later or never: not every kernel has netem.
"""

from __future__ import annotations

import heapq
import itertools
import random
import selectors
import socket
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field

# Of linux/if_ether.h and linux/if_packet.h, which Python does not name.
_ALL_PROTOCOLS = 0x0003
_SOL_PACKET, _IGNORE_OUTGOING, _VNET_HEADER = 263, 23, 15
_PACKET_BYTES = 1 << 17
_QUEUE_S = 1.0  # what would wait longer on a full line is lost, as in a router
_order = itertools.count()


def packets(interface: str) -> socket.socket:
    """A socket for whole packets, which leaves checksums and segments to the kernel."""
    raw = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0)
    raw.setsockopt(_SOL_PACKET, _VNET_HEADER, 1)
    raw.setsockopt(_SOL_PACKET, _IGNORE_OUTGOING, 1)
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    raw.bind((interface, _ALL_PROTOCOLS))
    return raw


@dataclass(slots=True, kw_only=True)
class Direction:
    """Packets on their way to one end."""

    out: socket.socket
    delay_s: float
    loss: float
    bytes_per_s: float
    free_at_s: float = 0.0
    waiting: list[tuple[float, int, bytes]] = field(default_factory=list)

    def take(self, packet: bytes, now_s: float) -> None:
        start_s = max(now_s, self.free_at_s)
        if random.random() < self.loss or start_s - now_s > _QUEUE_S:
            return
        self.free_at_s = start_s + len(packet) / self.bytes_per_s
        heapq.heappush(self.waiting, (self.free_at_s + self.delay_s, next(_order), packet))

    def send_due(self, now_s: float) -> None:
        while self.waiting and self.waiting[0][0] <= now_s:
            with suppress(OSError):  # the interface is down
                self.out.send(heapq.heappop(self.waiting)[2])

    @property
    def due_s(self) -> float:
        return self.waiting[0][0] if self.waiting else float("inf")


def relay(first: str, second: str, delay_s: float, loss: float, bytes_per_s: float) -> None:
    settings = {"delay_s": delay_s, "loss": loss, "bytes_per_s": bytes_per_s}
    ends = packets(first), packets(second)
    ways = [Direction(out=end, **settings) for end in reversed(ends)]
    with selectors.DefaultSelector() as selector:
        for end, way in zip(ends, ways, strict=True):
            selector.register(end, selectors.EVENT_READ, way)
        print("ready", flush=True)
        while True:
            due_s = min(way.due_s for way in ways) - time.monotonic()
            for key, _ in selector.select(None if due_s == float("inf") else max(due_s, 0.0)):
                with suppress(OSError):  # the interface is down
                    key.data.take(key.fileobj.recv(_PACKET_BYTES), time.monotonic())
            for way in ways:
                way.send_due(time.monotonic())


if __name__ == "__main__":
    relay(sys.argv[1], sys.argv[2], *map(float, sys.argv[3:]))
