"""How the nodes of an active run find each other, for verbs in a shell that does not say it.

A run with `--discovery server` has its own server, whose port is not published.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from typing import Any

from launcher.posix import socket_directory

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.control.client import Connection

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
            "several runs on this domain have different discovery servers or peers: set "
            "ROS_DISCOVERY_SERVER or ROS_STATIC_PEERS for the nodes of one"
        )
    for settings in found:
        environment.update({name: value for name, value in settings if value})
    return None


def _settings(domain: Callable[[], int]) -> Iterator[Mapping[str, str]]:
    for run in greetings():
        settings = run.get("discovery")
        if settings and run.get("domain_id") == domain():
            yield settings


def greetings() -> Iterator[Mapping[str, Any]]:
    """What the active runs of this user say of themselves."""
    for connection in connections():
        yield connection.hello["run"]


def connections() -> Iterator[Connection]:
    """Connections to the active runs of this user, each until the next."""
    for path in socket_directory.sockets(os.environ, os.getuid()):
        from launcher.control.client import Connection

        with (
            contextlib.suppress(socket_directory.ControlError),
            Connection(path, timeout_s=_TIMEOUT_S) as connection,
        ):
            yield connection
