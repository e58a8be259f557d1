"""Introduces participants that the follower knows to our node of rclpy.

Two participants that start at the same time lose each other's first announcements, and the next
come up to 3 s later (see `discovery.prefetch`). What the follower has received is repeated to our
own participant, which then announces itself to the other one.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING

from launcher.posix.ports import announcement_ports
from launcher.ros.discovery import rtps
from launcher.ros.discovery.gids import sockets_of

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.discovery.participant import Participant

_PERIOD_S = 0.2


class Introductions:
    """Call `introduce` regularly."""

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._next_s = 0.0
        held = sockets_of(os.getpid())
        ports = announcement_ports(observer.domain_id)
        self._ports = [port for inode, port in ports.items() if inode in held]

    def introduce(self, peers: Iterable[Participant]) -> None:
        """Repeat the announcements of those that our node does not know."""
        now = time.monotonic()
        if now < self._next_s:
            return
        self._next_s = now + _PERIOD_S
        known = self._observer.participants()
        unknown = [peer for peer in peers if peer.prefix not in known]
        if not unknown:
            return
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for peer in unknown:
                part = rtps.repeated(rtps.SPDP_READER, peer.announcement)
                datagram = rtps.message(peer.prefix, peer.prefix[:2], part)
                for port in self._ports:
                    with contextlib.suppress(OSError):
                        sender.sendto(datagram, ("127.0.0.1", port))
