"""Whether there are more nodes on this machine than find each other, before they are started.

Fast DDS gives each participant of a domain on a machine the next free port. With the discovery
range LOCALHOST it announces itself to the first 32 of them; with any other, the limit is 101.
Each process with a node is at least one participant.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from launcher.base.text import count

LOCALHOST_MAX = 33  # the first 32 discover all; each other one discovers these and itself
DOMAIN_MAX = 101
_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_RMW = ("", "rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp")
_WIDE = ("SUBNET", "SYSTEM_DEFAULT")


def limit(environment: Mapping[str, str]) -> int | None:
    """How many participants of one domain find each other here; None: no limit that is known."""
    if environment.get("RMW_IMPLEMENTATION", "") not in _RMW:
        return None
    if any(environment.get(name) for name in PROFILES):
        return None  # it may say anything about ports and peers
    if environment.get("ROS_DISCOVERY_SERVER"):
        return DOMAIN_MAX
    reach = environment.get(_RANGE) or "SUBNET"
    if environment.get("ROS_LOCALHOST_ONLY") == "1":
        return LOCALHOST_MAX
    if reach == "OFF":
        return None
    return DOMAIN_MAX if reach in _WIDE else LOCALHOST_MAX  # what is no range means LOCALHOST


def too_many(environments: Iterable[Mapping[str, str]], present: Mapping[int, int]) -> list[str]:
    """A message for each domain with too many: of the nodes to be started, by their environments.

    `present` are the participants that already run, by domain.
    """
    groups: Counter[tuple[int, int, bool]] = Counter()
    for environment in environments:
        most, domain = limit(environment), environment.get("ROS_DOMAIN_ID") or "0"
        if most is not None and domain.isdecimal():
            has_server = bool(environment.get("ROS_DISCOVERY_SERVER"))
            groups[int(domain[:9]), most, has_server] += 1
    return [
        _message(nodes, present.get(domain, 0), domain, most, has_server)
        for (domain, most, has_server), nodes in sorted(groups.items())
        if nodes + present.get(domain, 0) > most
    ]


def _message(nodes: int, others: int, domain: int, most: int, has_server: bool) -> str:
    running = f", besides {others} that run already," if others else ""
    head = f"{count(nodes, 'node')} on domain {domain}{running}"
    if most == DOMAIN_MAX:
        why = f"Fast DDS has ports for {DOMAIN_MAX} processes of a domain on one machine, and the "
        text = f"{head}: {why}others find no node"
    else:
        text = f"{head} do not all find each other: with {_RANGE}=LOCALHOST, {most} do"
    return f"{text}; {_repair(nodes + others, has_server)}"


def _repair(number: int, has_server: bool) -> str:
    if has_server:
        return "let the launcher start the server, with --discovery server"
    other = f", or {_RANGE}=SUBNET" if number <= DOMAIN_MAX else ""
    return f"use --discovery server{other}"
