"""Ask participants whose answer to our announcement was lost to answer again.

A Fast DDS participant announces itself a moment before it listens, so answers that come at once
(as they do on one machine) are lost, and the next comes with the regular announcement, up to 3 s
later. A participant answers every new one. So ours disposes of its announcement, as it does at its
end (RTPS 2.x, 8.5.3: a disposed DATA(p)), only at the participants that it has not discovered. In
its first half second it announces itself every 100 ms anyway: to them it is then new again, and by
now it listens.

Only old participants are asked. One that is just starting discovers us at the same time by its own
announcements; if it forgot us after it has received our endpoints, we would not send them again.

Measured with 20 participants, where rclpy alone reads the graph (`ROS_STATIC_PEERS` and the like;
the probe and `graph --watch` as well): `topic list`, `node list`, `topic info -v` and `graph` take
2.1 to 2.4 s and saw all in 24 of 24 runs; without this, 3.5 to 4.0 s, and in some runs as few as
10.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from launcher.posix import proc
from launcher.posix.ports import announcement_ports
from launcher.ros.discovery import rtps
from launcher.ros.discovery.gids import PARTICIPANT_BYTES, holders, pid_low16, scheme_holds

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

OLD_S = 2.0  # its first announcements are over by then
LATEST_S = 0.4  # after this, no announcement of ours may follow within the next 3 s


def reannounce_to_silent(observer: Observer) -> None:
    """Ask every participant of this machine that is not discovered; call it once, early."""
    own_gid = observer.own_gid()
    if not scheme_holds(own_gid, os.getpid()):
        return
    if time.monotonic() - observer.created_s > LATEST_S:
        return
    ports = announcement_ports(observer.domain_id)
    owned = {
        pid: sorted(ports[inode] for inode in inodes)
        for pid, inodes in holders(set(ports), set()).items()
        if _age_s(pid) >= OLD_S
    }
    dispose(own_gid[:PARTICIPANT_BYTES], silent_ports(owned, observer.participants()))


def _age_s(pid: int) -> float:
    ticks = proc.start_ticks(pid)
    if ticks is None:
        return 0.0
    return time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")


def silent_ports(owned: Mapping[int, Sequence[int]], known: set[bytes]) -> set[int]:
    """Of the ports of each process (sorted), those whose participant is not among the known.

    Fast DDS counts the participants of a process from 0, in bytes 8 to 11 of the GID, and gives
    them the lowest free port, so the n-th participant has the n-th port.
    """
    discovered: dict[int | None, set[int]] = {}
    for gid in known:
        discovered.setdefault(pid_low16(gid), set()).add(int.from_bytes(gid[8:12], "little"))
    return {
        port
        for pid, ports in owned.items()
        for number, port in enumerate(ports)
        if number not in discovered.get(pid & 0xFFFF, set())
    }


def dispose(participant: bytes, ports: set[int]) -> None:
    """Make the participants at these local ports forget ours, whose GID prefix is given."""
    message = disposal(participant)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for port in sorted(ports):
            sender.sendto(message, ("127.0.0.1", port))


def disposal(participant: bytes) -> bytes:
    """The RTPS message by which a participant (its 12 bytes) disposes of itself."""
    return rtps.message(participant, participant[:2], rtps.end_of_participant(participant, 2))
