"""A ROS domain that no run of this user has, and in which nobody answers."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from launcher.base.model.record import replace
from launcher.posix import domains
from launcher.posix.domain_lease import leased_domain
from launcher.ros.discovery.discovery_reader import DiscoveryReader, UnsupportedDiscovery
from launcher.ros.discovery.run_settings import greetings

if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions

_MOST_ASKED = 5  # domains; with so many hosts in them another one is no better


@contextlib.contextmanager
def free_domain() -> Iterator[int]:
    """Hold it until the end of the block; NoFreeDomainError if this machine uses all of them."""
    taken = {run.get("domain_id") for run in greetings()}
    asked = 0

    def is_free(domain_id: int) -> bool:
        nonlocal asked
        asked += 1
        return domain_id not in taken and (asked > _MOST_ASKED or not _answers(domain_id))

    with leased_domain(is_free) as domain_id:
        yield domain_id


def _answers(domain_id: int) -> bool:
    """Whether there are participants on other machines; those of this one hold ports."""
    if domains.localhost_only() or not domains.is_plain():
        return False
    try:
        with DiscoveryReader(domain_id, remote=True) as reader:
            reader.read(domains.REMOTE_S)
            return bool(reader.participants)
    except OSError:
        return False  # there is no network
    except UnsupportedDiscovery:
        return True


@contextlib.contextmanager
def of_run(options: RunOptions) -> Iterator[RunOptions]:
    """Hold one for all processes of the run that is evaluated within the block.

    The options that it yields have its id, since launch files may change the environment.
    """
    with free_domain() as domain_id:
        os.environ["ROS_DOMAIN_ID"] = str(domain_id)
        yield replace(options, domain_id=domain_id)
