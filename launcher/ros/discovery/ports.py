"""Ports: which ROS domains are in use on this machine, told from the UDP ports that are bound.

A DDS participant binds two ports whose numbers follow from the domain and its index on the host:
7400 + 250 * domain + 10 + 2 * index, and the one above. They go when the process goes, so they
tell, before anything has been discovered, how many participants there are to be found.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

TABLES = (Path("/proc/net/udp"), Path("/proc/net/udp6"))

_BASE = 7400
_PER_DOMAIN = 250
_FIRST_UNICAST = 10
_LAST_UNICAST = 248
MAX_DOMAIN = 232  # above it the ports would pass 65535


def participants_by_domain(tables: tuple[Path, ...] = TABLES) -> Counter[int]:
    """Domain -> number of participants on this machine; empty where there is no /proc."""
    return participants_of({port for port, _ in _bound(tables)})


def socket_inodes(domain_id: int, tables: tuple[Path, ...] = TABLES) -> set[str]:
    """Inodes of the sockets that hold ports of a domain."""
    low = _BASE + _PER_DOMAIN * domain_id
    return {inode for port, inode in _bound(tables) if low <= port < low + _PER_DOMAIN}


def udp_inodes(tables: tuple[Path, ...] = TABLES) -> set[str]:
    """Inodes of all UDP sockets."""
    return {inode for _, inode in _bound(tables)}


def announcement_ports(domain_id: int, tables: tuple[Path, ...] = TABLES) -> dict[str, int]:
    """Inode -> port, of the ports on which the participants of a domain hear announcements."""
    low = _BASE + _PER_DOMAIN * domain_id
    return {
        inode: port
        for port, inode in _bound(tables)
        if _FIRST_UNICAST <= port - low <= _LAST_UNICAST and (port - low) % 2 == 0
    }


def occupied_ports(domain_id: int, tables: tuple[Path, ...] = TABLES) -> set[int]:
    """The ports on which the participants of a domain on this machine hear announcements."""
    bound = {port for port, _ in _bound(tables)}
    first = multicast_port(domain_id) + _FIRST_UNICAST
    last = multicast_port(domain_id) + _LAST_UNICAST
    # the second port of the pair keeps a stranger's single port from being counted
    return {port for port in range(first, last + 1, 2) if {port, port + 1} <= bound}


def multicast_port(domain_id: int) -> int:
    """The port on which all participants of a domain hear, on every machine."""
    return _BASE + _PER_DOMAIN * domain_id


def _bound(tables: tuple[Path, ...]) -> Iterator[tuple[int, str]]:
    """Port and inode of every UDP socket, most of them twice.

    The kernel writes the table in pieces, and may skip a line where sockets are closed between two
    pieces; a second reading has it.
    """
    for table in 2 * tables:
        try:
            lines = table.read_text(encoding="ascii").splitlines()[1:]
        except OSError:
            continue  # no IPv6, or no /proc at all
        for line in lines:
            fields = line.split()
            yield int(fields[1].rpartition(":")[2], 16), fields[9]


def participants_of(bound: set[int]) -> Counter[int]:
    """The same from a set of port numbers."""
    found: Counter[int] = Counter()
    for port in bound:
        domain, offset = divmod(port - _BASE, _PER_DOMAIN)
        unicast = _FIRST_UNICAST <= offset <= _LAST_UNICAST and offset % 2 == 0
        # the second port of the pair keeps a stranger's single port from being counted
        if 0 <= domain <= MAX_DOMAIN and unicast and port + 1 in bound:
            found[domain] += 1
    return found
