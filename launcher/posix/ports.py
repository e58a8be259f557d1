"""Which ROS domains are in use on this machine, from the UDP ports that are bound.

A DDS participant binds two ports whose numbers follow from the domain and from its index on the
host: 7400 + 250 * domain + 10 + 2 * index, and the next one. The kernel frees them when the process
ends, so they give the number of participants before any of them has been discovered.
"""

from __future__ import annotations

from collections import Counter

from launcher.posix import proc

_FIRST_PORT = 7400
_PORTS_PER_DOMAIN = 250
_UNICAST = range(10, 250, 2)  # offsets of the ports for announcements
MAX_DOMAIN = 232  # above it the ports would pass 65535


def participants_by_domain() -> Counter[int]:
    """Domain -> number of participants on this machine; empty where there is no /proc."""
    return participants_of({port for port, _ in proc.udp_sockets()})


def participants_of(bound: set[int]) -> Counter[int]:
    """Domain -> number of participants that hold these ports."""
    return Counter(
        domain
        for domain, offset in (divmod(port - _FIRST_PORT, _PORTS_PER_DOMAIN) for port in bound)
        if 0 <= domain <= MAX_DOMAIN
        and offset in _UNICAST
        # a single port belongs to some other program
        and multicast_port(domain) + offset + 1 in bound
    )


def busy_domains() -> set[int]:
    """Domains with an open UDP port."""
    ports = {port for port, _ in proc.udp_sockets()}
    return {(port - _FIRST_PORT) // _PORTS_PER_DOMAIN for port in ports if port >= _FIRST_PORT}


def occupied_ports(domain_id: int) -> set[int]:
    """The ports for announcements that participants of a domain have on this machine."""
    return set(occupied_sockets(domain_id))


def occupied_sockets(domain_id: int) -> dict[int, str]:
    """The same, with the inode of a socket for each port: another one if it was bound again."""
    low, bound = multicast_port(domain_id), dict(sorted(proc.udp_sockets(), reverse=True))
    ports = (low + offset for offset in _UNICAST)
    return {port: bound[port] for port in ports if port in bound and port + 1 in bound}


def announcement_ports(domain_id: int) -> dict[str, int]:
    """Inode -> port, of the sockets on which participants of a domain receive announcements."""
    low = multicast_port(domain_id)
    return {inode: port for port, inode in proc.udp_sockets() if port - low in _UNICAST}


def socket_inodes(domain_id: int) -> set[str]:
    """Inodes of the sockets that hold ports of a domain."""
    ports = range(multicast_port(domain_id), multicast_port(domain_id + 1))
    return {inode for port, inode in proc.udp_sockets() if port in ports}


def multicast_port(domain_id: int) -> int:
    """The port on which all participants of a domain, on every machine, receive announcements."""
    return _FIRST_PORT + _PORTS_PER_DOMAIN * domain_id
