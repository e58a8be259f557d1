"""Processes behind the graph: what an endpoint's GID tells about the process that owns it.

Fast DDS builds a GID from its vendor id 01.0f, two bytes of the host, and the low 16 bits of the
process id (little endian), so a local endpoint leads to its process. Other vendors do not.
"""

from __future__ import annotations

import os

FAST_DDS = b"\x01\x0f"
PARTICIPANT_BYTES = 12  # of a GID: the part that all endpoints of a participant share


def pid_low16(gid: bytes) -> int | None:
    """The low 16 bits of the owner's process id; None if the GID is not one of Fast DDS."""
    if gid[:2] != FAST_DDS:
        return None
    return int.from_bytes(gid[4:6], "little")


def same_host(gid: bytes, own_gid: bytes) -> bool:
    """Whether both endpoints live on one host (then both speak Fast DDS)."""
    return gid[:2] == FAST_DDS and gid[:4] == own_gid[:4]


def scheme_holds(own_gid: bytes, own_pid: int) -> bool:
    """Whether a GID of this process tells its process id: checked before others' are believed."""
    return pid_low16(own_gid) == own_pid & 0xFFFF


def living_pids() -> list[int]:
    """Every process on this machine that is no zombie."""
    return [int(name) for name in os.listdir("/proc") if name.isdigit() and not _is_zombie(name)]


def _is_zombie(pid: str) -> bool:
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            return file.read().rpartition(b") ")[2][:1] in (b"Z", b"X")
    except OSError:
        return True


def ghosts(gids: set[bytes], own_gid: bytes, own_pid: int) -> set[bytes]:
    """Those GIDs of this host whose process is gone; none where the scheme does not hold."""
    if not scheme_holds(own_gid, own_pid):
        return set()
    living = {pid & 0xFFFF for pid in living_pids()}
    return {gid for gid in gids if same_host(gid, own_gid) and pid_low16(gid) not in living}
