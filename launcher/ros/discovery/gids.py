"""Processes behind the graph: what an endpoint's GID tells about the process that owns it.

Fast DDS builds a GID from its vendor id 01.0f, two bytes of the host, and the low 16 bits of the
process id (little endian), so a local endpoint leads to its process. Other vendors do not.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time
from dataclasses import dataclass

from launcher.ros.discovery.ports import participants_by_domain, socket_inodes, udp_inodes

ROOM_BYTES = 4 << 20
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


def is_alive(pid: int) -> bool:
    """Whether the process is there and no zombie."""
    return not _is_zombie(str(pid))


def all_live(participants: set[bytes], own_gid: bytes, domain_id: int) -> bool:
    """Whether as many participants hold ports on this machine as are known of it.

    Then none of them is a ghost, even one whose process id is of another container.
    """
    local = sum(same_host(gid, own_gid) for gid in participants)
    return local <= participants_by_domain()[domain_id]


def ghosts(gids: set[bytes], own_gid: bytes, own_pid: int) -> set[bytes]:
    """Those GIDs of this host whose process is gone; none where the scheme does not hold."""
    if not scheme_holds(own_gid, own_pid):
        return set()
    living = {pid & 0xFFFF for pid in living_pids()}
    return {gid for gid in gids if same_host(gid, own_gid) and pid_low16(gid) not in living}


class Vanished(Exception):
    """The process ended while it was looked at, or is not ours to look at."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Vitals:
    """What /proc tells about a process at one moment; `state` is its letter there."""

    pid: int
    state: str
    cpu_s: float
    rss_bytes: int
    uptime_s: float


def vitals(pid: int) -> Vitals:
    """Raises Vanished."""
    fields = _read(pid, "stat").rpartition(b") ")[2].split()
    resident_pages = int(_read(pid, "statm").split()[1])
    ticks = os.sysconf("SC_CLK_TCK")
    return Vitals(
        pid=pid,
        state=fields[0].decode(),
        cpu_s=(int(fields[11]) + int(fields[12])) / ticks,
        rss_bytes=resident_pages * os.sysconf("SC_PAGE_SIZE"),
        uptime_s=time.clock_gettime(time.CLOCK_BOOTTIME) - int(fields[19]) / ticks,
    )


def program_name(pid: int) -> str:
    """What a person calls the process: the module or script of a Python, else the program."""
    words = _read(pid, "cmdline").decode(errors="replace").rstrip("\0").split("\0")
    program = os.path.basename(words[0])
    if not program.startswith("python"):
        return program
    for index, word in enumerate(words[1:], start=1):
        if word == "-m":
            return " ".join(words[index + 1 : index + 2]) or program
        if word == "-c":
            return f"{program} -c"
        if not word.startswith("-"):
            return os.path.basename(word)
    return program


def variable(pid: int, name: str) -> str | None:
    """An entry of the environment with which the process was started; Vanished."""
    prefix = f"{name}=".encode()
    for entry in _read(pid, "environ").split(b"\0"):
        if entry.startswith(prefix):
            return entry[len(prefix) :].decode(errors="replace")
    return None


def find_pid(low16: int, domain_id: int) -> int | None:
    """The living process with these low bits that holds ports of the domain; None if not sure."""
    # a process with the network of this machine and process ids of its own (in a container) tells
    # a number that is somebody else's here
    candidates = [p for p in living_pids() if p & 0xFFFF == low16 and _may_talk(p, udp_inodes())]
    if len(candidates) > 1:
        inodes = socket_inodes(domain_id)
        candidates = [pid for pid in candidates if inodes & sockets_of(pid)]
    if not candidates:
        held = holders(socket_inodes(domain_id), set())
        candidates = [pid for pid in held if innermost_pid(pid) & 0xFFFF == low16]
    return candidates[0] if len(candidates) == 1 else None


def innermost_pid(pid: int) -> int:
    """The number that a process has for itself, in its own namespace; 0 if it has ended."""
    with contextlib.suppress(Vanished):
        for line in _read(pid, "status").splitlines():
            if line.startswith(b"NSpid:"):
                return int(line.split()[-1])
    return 0


def _may_talk(pid: int, inodes: set[str]) -> bool:
    """Whether a process holds one of these sockets, or is not ours to look at."""
    if not os.access(f"/proc/{pid}/fd", os.R_OK | os.X_OK):
        return True
    return bool(sockets_of(pid) & inodes)


def holders(inodes: set[str], known: set[int | None]) -> dict[int, set[str]]:
    """Processes that hold some of these sockets, by pid, those with known low bits left out."""
    unknown = [pid for pid in living_pids() if pid & 0xFFFF not in known and pid != os.getpid()]
    return {pid: held for pid in unknown if (held := sockets_of(pid) & inodes)}


def sockets_of(pid: int) -> set[str]:
    """Inodes of the sockets that a process holds; none if it is not ours to look at."""
    found: set[str] = set()
    try:
        for entry in os.scandir(f"/proc/{pid}/fd"):
            link = os.readlink(entry.path)
            if link.startswith("socket:["):
                found.add(link[8:-1])
    except OSError:
        return found  # it has ended, or belongs to somebody else
    return found


def widen_sockets(inodes: set[str]) -> None:
    """Give those of these sockets that are this process's room for a burst.

    To a participant that has just come everybody tells all that he has, at the same time: some
    hundred datagrams, and what finds no room comes again only seconds later. A profile of Fast DDS
    could say so as well, but rmw_fastrtps overrides it where discovery stays on this machine.
    """
    for entry in os.scandir("/proc/self/fd"):
        with contextlib.suppress(OSError):  # closed meanwhile
            if os.readlink(entry.path).removeprefix("socket:[").rstrip("]") in inodes:
                with socket.socket(fileno=os.dup(int(entry.name))) as held:
                    held.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM_BYTES)


def _read(pid: int, name: str) -> bytes:
    try:
        with open(f"/proc/{pid}/{name}", "rb") as file:
            return file.read()
    except OSError as error:
        raise Vanished(f"process {pid}: {error.strerror}") from None
