"""How the nodes of an active run find each other, for verbs in a shell that does not say it.

A run with `--discovery server` has its own server, whose port nobody else knows.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, MutableMapping

from launcher.posix import socket_directory

_TIMEOUT_S = 0.3  # a run that takes longer is busy or suspended
_OWN = ("ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS")


def adopt(environment: MutableMapping[str, str], domain: Callable[[], int]) -> str | None:
    """Set the variables of the run on this domain, unless the environment has its own.

    Returns a warning if there are several runs, whose nodes find each other in different ways.
    """
    if any(environment.get(name) for name in _OWN):
        return None
    found = {tuple(sorted(one.items())) for one in _settings(domain)}
    if len(found) > 1:
        return (
            "several runs on this domain have discovery servers or peers of their own: set "
            "ROS_DISCOVERY_SERVER or ROS_STATIC_PEERS for the nodes of one"
        )
    for settings in found:
        environment.update({name: value for name, value in settings if value})
    return None


def _settings(domain: Callable[[], int]) -> Iterator[Mapping[str, str]]:
    paths = socket_directory.sockets(os.environ, os.getuid())
    for path in paths:
        from launcher.control.client import Connection

        with (
            contextlib.suppress(socket_directory.ControlError),
            Connection(path, timeout_s=_TIMEOUT_S) as connection,
        ):
            run = connection.hello["run"]
            settings = run.get("discovery")
            if settings and run.get("domain_id") == domain():
                yield settings
