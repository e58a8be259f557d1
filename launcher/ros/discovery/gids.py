"""From the GID of an endpoint to the process that owns it.

Fast DDS builds a GID from its vendor id 01.0f, two bytes of the host, and the low 16 bits of the
process id (little endian). Other vendors do not.
"""

from __future__ import annotations

import contextlib
import os
import socket

from launcher.posix import proc
from launcher.posix.ports import participants_by_domain, socket_inodes

ROOM_BYTES = 4 << 20
FAST_DDS = b"\x01\x0f"
PARTICIPANT_BYTES = 12  # of a GID: what all endpoints of a participant share


def participant_of(gid: str) -> str:
    """The part of a GID (dotted hex) that all endpoints of a participant share."""
    return gid[: 3 * PARTICIPANT_BYTES - 1]


def pid_low16(gid: bytes) -> int | None:
    """The low 16 bits of the owner's process id; None if the GID is not one of Fast DDS."""
    return int.from_bytes(gid[4:6], "little") if gid[:2] == FAST_DDS else None


def same_host(gid: bytes, own_gid: bytes) -> bool:
    """Whether both endpoints are on one host, and of Fast DDS."""
    return gid[:2] == FAST_DDS and gid[:4] == own_gid[:4]


def scheme_holds(own_gid: bytes, own_pid: int) -> bool:
    """Whether a GID of this process contains its process id; check before relying on others."""
    return pid_low16(own_gid) == own_pid & 0xFFFF


def living_pids() -> list[int]:
    """Every process on this machine that is not a zombie."""
    return [pid for pid in proc.pids() if proc.is_alive(pid)]


def all_live(participants: set[bytes], own_gid: bytes, domain_id: int) -> bool:
    """Whether as many participants hold ports on this machine as are known of it.

    Then none of them is a ghost, even one whose process id is of another container.
    """
    local = sum(same_host(gid, own_gid) for gid in participants)
    return local <= participants_by_domain()[domain_id]


def ghosts(gids: set[bytes], own_gid: bytes, own_pid: int) -> set[bytes]:
    """The GIDs of this host whose process has ended; none where the scheme does not hold."""
    if not scheme_holds(own_gid, own_pid):
        return set()
    living = {pid & 0xFFFF for pid in living_pids()}
    return {gid for gid in gids if same_host(gid, own_gid) and pid_low16(gid) not in living}


def find_pid(low16: int, domain_id: int) -> int | None:
    """The process with these low bits that holds ports of the domain; None if it is ambiguous."""
    # a process in a container that shares our network has the pid of another namespace in its GID,
    # which belongs to some other process here
    candidates = [pid for pid in living_pids() if pid & 0xFFFF == low16 and _may_use_udp(pid)]
    inodes = socket_inodes(domain_id)
    if len(candidates) > 1:
        candidates = [pid for pid in candidates if inodes & sockets_of(pid)]
    if not candidates:
        held = holders(inodes, set())
        candidates = [pid for pid in held if innermost_pid(pid) & 0xFFFF == low16]
    return candidates[0] if len(candidates) == 1 else None


def innermost_pid(pid: int) -> int:
    """The pid of a process in its own namespace; 0 if it has ended."""
    return int((proc.status_field(pid, "NSpid") or "0").split()[-1])


def _may_use_udp(pid: int) -> bool:
    """Whether a process holds a UDP socket, or belongs to another user."""
    if not os.access(f"{proc.ROOT}/{pid}/fd", os.R_OK | os.X_OK):
        return True
    return bool(sockets_of(pid) & {inode for _, inode in proc.udp_sockets()})


def holders(inodes: set[str], known: set[int | None]) -> dict[int, set[str]]:
    """Processes that hold some of these sockets, by pid, except those with known low bits."""
    unknown = [pid for pid in living_pids() if pid & 0xFFFF not in known and pid != os.getpid()]
    return {pid: held for pid in unknown if (held := sockets_of(pid) & inodes)}


def sockets_of(pid: int) -> set[str]:
    """Inodes of the sockets of a process; none if it belongs to another user."""
    links = (link for _, link in proc.descriptors(pid))
    return {link[8:-1] for link in links if link.startswith("socket:[")}


def widen_sockets(inodes: set[str]) -> None:
    """Enlarge the receive buffers of this process's sockets among these.

    All participants send all their endpoints to a new one at the same time: some hundred
    datagrams, and what does not fit is repeated seconds later. A profile of Fast DDS could set
    this, too, but rmw_fastrtps overrides it where discovery is limited to this machine.
    """
    for fd, link in proc.descriptors(os.getpid()):
        if link.removeprefix("socket:[").rstrip("]") in inodes:
            # It may have been closed meanwhile.
            with contextlib.suppress(OSError), socket.socket(fileno=os.dup(fd)) as held:
                held.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM_BYTES)
