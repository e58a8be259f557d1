"""Nudge: asks participants whose answer was lost to answer again.

A Fast DDS participant announces itself a moment before it listens, so answers that come at once
(as they do on one machine) are lost, and the next comes with the regular announcement, up to 3 s
later. A participant answers whoever is new to it. So ours takes its announcement back, as it does
at its end (RTPS 2.x, 8.5.3: a disposed DATA(p)), at those participants alone that it has not
heard of. It goes on announcing itself every 100 ms in its first half second; to them it is new
again, and by now it listens.

Only old participants are asked: one that is just starting hears of us by its own announcements at
the same time, and if it forgot us after we have told it what we have, we would not tell it again.
"""

from __future__ import annotations

import os
import socket
import struct
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from launcher.ros.discovery.gids import Vanished, holders, pid_low16, scheme_holds, vitals
from launcher.ros.discovery.ports import announcement_ports

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

OLD_S = 2.0  # its first announcements are over by then
LATEST_S = 0.4  # after this, no announcement of ours may follow within the next 3 s

_ENTITY_PARTICIPANT = bytes.fromhex("000001c1")
_ENTITY_WRITER = bytes.fromhex("000100c2")  # announces participants
_ENTITY_READER = bytes.fromhex("000100c7")
_DATA, _LITTLE_ENDIAN, _INLINE_QOS = 0x15, 0x01, 0x02
_PID_SENTINEL, _PID_KEY_HASH, _PID_STATUS = 0x0001, 0x0070, 0x0071
_DISPOSED_AND_UNREGISTERED = bytes([0, 0, 0, 3])


def reannounce_to_silent(observer: Observer) -> None:
    """Ask every process of this domain and machine that has not been heard of; once, and early."""
    own_gid = observer.own_gid()
    if not scheme_holds(own_gid, os.getpid()):
        return
    if time.monotonic() - observer.created_s > LATEST_S:
        return
    if silent := _silent_ports(observer):
        take_back(own_gid[:12], silent)


def _silent_ports(observer: Observer) -> set[int]:
    """Ports of the participants that are not known."""
    ports = announcement_ports(observer.domain_id)
    owned = {
        pid: sorted(ports[inode] for inode in inodes)
        for pid, inodes in holders(set(ports), set()).items()
        if _is_old(pid)
    }
    return silent_ports(owned, observer.participants())


def _is_old(pid: int) -> bool:
    try:
        return vitals(pid).uptime_s >= OLD_S
    except Vanished:
        return False


def silent_ports(owned: Mapping[int, Sequence[int]], known: set[bytes]) -> set[int]:
    """Of the ports of each process (sorted), those whose participant is not among the known.

    Fast DDS counts the participants of a process from 0, in bytes 8 to 11 of the GID, and gives
    them the lowest free port, so the n-th participant has the n-th port.
    """
    heard: dict[int | None, set[int]] = {}
    for gid in known:
        heard.setdefault(pid_low16(gid), set()).add(int.from_bytes(gid[8:12], "little"))
    return {
        port
        for pid, ports in owned.items()
        for number, port in enumerate(ports)
        if number not in heard.get(pid & 0xFFFF, set())
    }


def take_back(participant: bytes, ports: set[int]) -> None:
    """Tell the participants at these local ports to forget ours, whose GID prefix is given."""
    message = taken_back(participant)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for port in sorted(ports):
            sender.sendto(message, ("127.0.0.1", port))


def taken_back(participant: bytes) -> bytes:
    """The RTPS message: our participant (12 bytes) is disposed."""
    guid = participant + _ENTITY_PARTICIPANT
    qos = _parameter(_PID_KEY_HASH, guid) + _parameter(_PID_STATUS, _DISPOSED_AND_UNREGISTERED)
    body = struct.pack("<HH", 0, 16) + _ENTITY_READER + _ENTITY_WRITER + struct.pack("<iI", 0, 2)
    body += qos + _parameter(_PID_SENTINEL)
    flags = _LITTLE_ENDIAN | _INLINE_QOS
    header = b"RTPS" + bytes([2, 3]) + participant[:2] + participant
    return header + struct.pack("<BBH", _DATA, flags, len(body)) + body


def _parameter(number: int, value: bytes = b"") -> bytes:
    return struct.pack("<HH", number, len(value)) + value
