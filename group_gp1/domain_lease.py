"""A lease on a ROS domain: an id that no other experiment or test on this machine uses now."""

from __future__ import annotations

import contextlib
import fcntl
import os
import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

# Above 101 the UDP ports of DDS run into the range that the kernel gives to other programs;
# the small ids are the ones that people type.
_DOMAIN_IDS = range(20, 102)


class NoFreeDomainError(RuntimeError):
    """Every domain id in the range is leased."""


@contextlib.contextmanager
def leased_domain() -> Iterator[int]:
    """Hold a free domain id; the lock goes with the process, however that ends."""
    with contextlib.ExitStack() as stack:
        for domain_id in random.sample(_DOMAIN_IDS, k=len(_DOMAIN_IDS)):
            lock = stack.enter_context(_lock_file(domain_id).open("w"))
            with contextlib.suppress(BlockingIOError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                yield domain_id
                return
    raise NoFreeDomainError(f"no free ROS domain id in {_DOMAIN_IDS}")


def _lock_file(domain_id: int) -> Path:
    folder = Path(tempfile.gettempdir()) / f"ros-domain-leases-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder / str(domain_id)
