"""Leases of ROS domain ids that are not in use on this machine."""

from __future__ import annotations

import contextlib
import errno
import random
import socket
from collections.abc import Callable, Iterator

from launcher.base.errors import LauncherError
from launcher.posix.ports import busy_domains

# Above 101 the UDP ports are in the ephemeral range of Linux; users choose small ids.
_DOMAIN_IDS = range(20, 102)


class NoFreeDomainError(LauncherError):
    """All domain ids are leased or in use."""


@contextlib.contextmanager
def leased_domain(accepts: Callable[[int], bool] = lambda domain_id: True) -> Iterator[int]:
    """Hold a free domain id; the lease ends with the process at the latest.

    Domains with open UDP ports are not free, even without a lease, nor those that `accepts`
    refuses. Children that use the domain must end before the lease. Raises NoFreeDomainError.
    """
    busy = busy_domains()
    for domain_id in random.sample(_DOMAIN_IDS, k=len(_DOMAIN_IDS)):
        if domain_id in busy:
            continue
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as lease:
            if _take(lease, domain_id) and accepts(domain_id):
                yield domain_id
                return
    first, last = _DOMAIN_IDS[0], _DOMAIN_IDS[-1]
    raise NoFreeDomainError(f"every ROS domain from {first} to {last} is in use on this machine")


def _take(lease: socket.socket, domain_id: int) -> bool:
    """Bind the abstract socket name of the domain; False if another process has it.

    Like the ports of the domain, it belongs to the network namespace and not to a user.
    """
    try:
        lease.bind(f"\0ros-domain-lease-{domain_id}")
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            raise
        return False
    return True
