"""Ports: which ROS domains are in use on this machine, told from the UDP ports that are bound.

A DDS participant binds two ports whose numbers follow from the domain and its index on the host:
7400 + 250 * domain + 10 + 2 * index, and the one above. They go when the process goes, so they
tell, before anything has been discovered, how many participants there are to be found.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

TABLES = (Path("/proc/net/udp"), Path("/proc/net/udp6"))

_BASE = 7400
_PER_DOMAIN = 250
_FIRST_UNICAST = 10
_LAST_UNICAST = 248
MAX_DOMAIN = 232  # above it the ports would pass 65535


def participants_by_domain(tables: tuple[Path, ...] = TABLES) -> Counter[int]:
    """Domain -> number of participants on this machine; empty where there is no /proc."""
    bound: set[int] = set()
    for table in tables:
        try:
            lines = table.read_text(encoding="ascii").splitlines()[1:]
        except OSError:
            continue
        bound |= {int(line.split()[1].rpartition(":")[2], 16) for line in lines}
    return participants_of(bound)


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
