"""Domains: which ROS domain is meant, how far discovery goes, and what to say of an empty one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from launcher.errors import UsageError
from launcher.graph.ports import MAX_DOMAIN, TABLES, participants_by_domain

SPIN_TIME_S = 3.5  # one period of Fast DDS's announcements, and time to tell what there is
REMOTE_S = 0.4  # what hosts that we cannot count are given at least

# What makes discovery other than plain RTPS on UDP with the ports of the standard.
_UNUSUAL = (
    "ROS_DISCOVERY_SERVER",
    "ROS_STATIC_PEERS",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "CYCLONEDDS_URI",
)
_PROFILES = "DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml"
_PLAIN_RMW = ("", "rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp", "rmw_cyclonedds_cpp")
_PLAIN_TRANSPORTS = ("", "DEFAULT", "UDPv4")


def environment_domain() -> int:
    """The domain that the environment names, 0 if none; UsageError if it is not one."""
    word = os.environ.get("ROS_DOMAIN_ID") or "0"
    return domain_of(word, "ROS_DOMAIN_ID")


def domain_of(word: str, source: str) -> int:
    """The domain id in `word`; UsageError that names the source."""
    if not word.isdigit() or int(word) > MAX_DOMAIN:
        raise UsageError(
            f"{source} is '{word}'", hint=f"a domain is a number from 0 to {MAX_DOMAIN}"
        )
    return int(word)


def localhost_only(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the environment keeps discovery on this machine."""
    if environment.get("ROS_LOCALHOST_ONLY") == "1":
        return True
    return environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET") in ("LOCALHOST", "OFF")


def is_plain(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the discovery of this environment is that of the standard, unchanged."""
    return (
        not any(environment.get(name) for name in _UNUSUAL)
        and environment.get("RMW_IMPLEMENTATION", "") in _PLAIN_RMW
        and environment.get("FASTDDS_BUILTIN_TRANSPORTS", "") in _PLAIN_TRANSPORTS
        and environment.get("ROS_SECURITY_ENABLE") != "true"
        and environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") != "OFF"
        and TABLES[0].exists()
        and not any(Path(name).exists() for name in _PROFILES)
    )


def why_empty(domain_id: int) -> str:
    """The sentence for a graph without nodes, with the domain on which there are some."""
    place = " (localhost only)" if localhost_only() else ""
    sentence = f"0 nodes on domain {domain_id}{place}"
    others = sorted(d for d in participants_by_domain() if d != domain_id)
    if not others:
        return f"{sentence}; no other domain is in use on this machine"
    if len(others) == 1:
        return f"{sentence}; a run on domain {others[0]} is active: add -d {others[0]}"
    names = ", ".join(map(str, others))
    return f"{sentence}; runs on domains {names} are active: add -d {others[0]}"
