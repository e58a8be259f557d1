"""Follows a ROS graph by its discovery messages (RTPS), without a DDS stack.

As `reader`, which reads it once. New participants are noticed by their ports, and those that have
ended by the sockets that are not there any more: DDS would notice a killed process only later.
"""

from __future__ import annotations

import time

from launcher.posix.ports import announcement_ports
from launcher.ros.discovery.discovery_reader import DiscoveryReader
from launcher.ros.discovery.participant import Participant

PORTS_S = 0.1  # from one look at the ports to the next
_DISPOSE_S = 0.4  # after it a port is silent: dispose, since a participant may know us already
_SUBSCRIBE_S = 0.5  # to the nodes of one participant, if that was lost
_RENEW_S = 3.0  # before the lease of our announcement ends


class DiscoveryFollower(DiscoveryReader):
    """Call `poll` regularly; `since` is when each participant was discovered (monotonic)."""

    def __init__(self, domain_id: int, *, remote: bool) -> None:
        super().__init__(domain_id, remote=remote)
        self.since: dict[bytes, float] = {}
        self._inodes: dict[bytes, str] = {}
        self._subscribed: dict[bytes, float] = {}
        self._silent_since: dict[int, float] = {}
        self._next_look_s = 0.0
        self._renewed_s = time.monotonic()

    def fileno(self) -> int:
        return self._socket.fileno()

    @property
    def version(self) -> object:
        """Changes with every participant and every sample."""
        return [(prefix, peer.arrived) for prefix, peer in self._peers.items()]

    @property
    def participants(self) -> list[Participant]:
        return list(self._peers.values())

    def poll(self) -> None:
        """Take what has arrived, and ask those that have not answered; without waiting."""
        now = time.monotonic()
        if now >= self._next_look_s:
            self._next_look_s = now + PORTS_S
            self._look(now)
        self._receive(0)
        self._repeat_requests(now)
        for prefix in self._peers.keys() - self.since.keys():
            self.since[prefix] = now
        for prefix in self.since.keys() - self._peers.keys():
            self._forget(prefix)

    def _look(self, now: float) -> None:
        inodes = {port: inode for inode, port in announcement_ports(self._domain_id).items()}
        for prefix, peer in list(self._peers.items()):
            if not peer.is_local:
                continue
            if self._inodes.setdefault(prefix, inodes.get(peer.port, "")) != inodes.get(peer.port):
                del self._peers[prefix]
        known = {peer.port for peer in self._peers.values() if peer.is_local}
        silent = inodes.keys() - known
        self._silent_since = {port: self._silent_since.get(port, now) for port in silent}
        late = {port for port, since_s in self._silent_since.items() if now - since_s > _DISPOSE_S}
        if late:
            self._dispose({("127.0.0.1", port) for port in late})
            self._silent_since.update(dict.fromkeys(late, now))
        addresses = self._addresses(set(silent)) if silent or self._is_renewing(now) else set()
        self._announce(addresses)

    def _is_renewing(self, now: float) -> bool:
        if now - self._renewed_s < _RENEW_S:
            return False
        self._renewed_s = now
        self._announce({peer.address for peer in self._peers.values()})
        return True

    def _subscribe(self, peer: Participant) -> None:
        """Not at each answer of the participant: it would answer to that again, without end."""
        now = time.monotonic()
        if now >= self._subscribed.get(peer.prefix, 0.0) + _SUBSCRIBE_S:
            self._subscribed[peer.prefix] = now
            super()._subscribe(peer)

    def _forget(self, prefix: bytes) -> None:
        """A participant has ended, or has said that it ends."""
        self.discovered = [peer for peer in self.discovered if peer.prefix != prefix]
        del self.since[prefix]
        self._inodes.pop(prefix, None)
        self._subscribed.pop(prefix, None)
