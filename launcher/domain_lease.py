"""A lease on a ROS domain: an id that nothing else on this machine uses now."""

from __future__ import annotations

import contextlib
import errno
import random
import socket
from collections.abc import Iterator
from pathlib import Path

from launcher.errors import LauncherError

# Above 101 the UDP ports of DDS run into the range that the kernel gives to other programs;
# the small ids are the ones that people type.
_DOMAIN_IDS = range(20, 102)
_FIRST_PORT, _PORTS_PER_DOMAIN = 7400, 250
_UDP_TABLES = ("/proc/net/udp", "/proc/net/udp6")


class NoFreeDomainError(LauncherError):
    """Every domain id in the range is leased or in use."""


@contextlib.contextmanager
def leased_domain() -> Iterator[int]:
    """Hold a free domain id; the lease goes with the process, however that ends.

    A domain without a lease whose UDP ports somebody has open is left to them. The children that
    run in the domain have ended before the lease does. Raises NoFreeDomainError.
    """
    busy = busy_domains()
    for domain_id in random.sample(_DOMAIN_IDS, k=len(_DOMAIN_IDS)):
        if domain_id in busy:
            continue
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as lease:
            if _take(lease, domain_id):
                yield domain_id
                return
    first, last = _DOMAIN_IDS[0], _DOMAIN_IDS[-1]
    raise NoFreeDomainError(f"every ROS domain from {first} to {last} is in use on this machine")


def _take(lease: socket.socket, domain_id: int) -> bool:
    """Bind the name that stands for the domain; False if another process has it.

    An abstract name belongs to the network namespace, as the ports of the domain do: all users
    are in it, whatever their TMPDIR, and it needs no file.
    """
    try:
        lease.bind(f"\0ros-domain-lease-{domain_id}")
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            raise
        return False
    return True


def busy_domains() -> set[int]:
    """Domains of which a UDP port is open, whoever opened it."""
    # Twice: the kernel may skip a line while other sockets are closed.
    ports = (port for table in 2 * _UDP_TABLES for port in _open_ports(table))
    return {(port - _FIRST_PORT) // _PORTS_PER_DOMAIN for port in ports if port >= _FIRST_PORT}


def _open_ports(table: str) -> Iterator[int]:
    try:
        lines = Path(table).read_text(encoding="ascii").splitlines()[1:]
    except OSError:
        return
    for line in lines:
        yield int(line.split()[1].rpartition(":")[2], 16)
