"""ROS domain ids, the range of discovery, and why a domain is empty."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, MutableMapping
from pathlib import Path

from launcher.base.errors import UsageError
from launcher.posix.ports import MAX_DOMAIN, participants_by_domain

SPIN_TIME_S = 3.5  # one period of Fast DDS's announcements, and time for the answers
SPIN_TIME_WITH_SERVER_S = 10.0  # a server announces a hundred nodes in rounds that take seconds
REMOTE_S = 0.4  # the least wait for other machines, whose participants cannot be counted

# Settings with which discovery is not plain RTPS on UDP with the ports of the standard.
PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_UNUSUAL = ("ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS", "CYCLONEDDS_URI")
RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
OFF = (
    "discovery is off (ROS_AUTOMATIC_DISCOVERY_RANGE=OFF); "
    "unset it, or set it to LOCALHOST or SUBNET"
)
_PROFILES = "DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml"
_PLAIN_RMW = ("", "rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp", "rmw_cyclonedds_cpp")
_PLAIN_TRANSPORTS = ("", "DEFAULT", "UDPv4")
# As rcl reads it, with C's strtoul: what follows the digits does not count, except after a 0.
_NUMBER = re.compile(r"\s*([+-]?)(0x[0-9a-f]+|0[0-7]*|[1-9][0-9]*)", re.ASCII | re.IGNORECASE)


def environment_domain() -> int:
    """ROS_DOMAIN_ID, 0 if it is not set; UsageError if it is not a domain."""
    word = os.environ.get("ROS_DOMAIN_ID") or "0"
    return domain_of(word, "ROS_DOMAIN_ID")


def domain_of(word: str, source: str) -> int:
    """The domain id in `word`; UsageError that names the source."""
    if not word.isdigit() or int(word) > MAX_DOMAIN:
        raise UsageError(
            f"{source} is '{word}'", hint=f"a domain is a number from 0 to {MAX_DOMAIN}"
        )
    return int(word)


def is_domain(word: str) -> bool:
    """Whether a node with this value of ROS_DOMAIN_ID can start."""
    if not word:
        return True
    found = _NUMBER.match(word)
    if found is None:
        return False
    sign, digits = found.groups()
    is_octal = digits.startswith("0") and digits[1:2] not in ("x", "X")
    number = int(digits, 8 if is_octal else 0)
    if number == 0:
        return found.end() == len(word)
    return sign != "-" and number <= MAX_DOMAIN


def _discovery_range(environment: Mapping[str, str]) -> str:
    """How far discovery goes, as rcl reads the environment."""
    if environment.get("ROS_LOCALHOST_ONLY") == "1":  # beats the other
        return "LOCALHOST"
    word = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or "SUBNET"
    return word if word in RANGES else "LOCALHOST"


def is_off(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether discovery is off, even on this machine."""
    return _discovery_range(environment) == "OFF"


def localhost_only(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the environment keeps discovery on this machine."""
    if environment.get("ROS_DISCOVERY_SERVER"):
        return False
    found = _discovery_range(environment)
    has_peers = environment.get("ROS_STATIC_PEERS") and environment.get("ROS_LOCALHOST_ONLY") != "1"
    return found == "OFF" or (found == "LOCALHOST" and not has_peers)


def least_wait_s(environment: Mapping[str, str] = os.environ) -> float:
    """How long participants on other machines, which cannot be counted, are waited for.

    Of those at static peers the first answer is often lost, and the next comes with the next
    announcement: in 4 of 7 runs some were missing after 1 s.
    """
    if localhost_only(environment):
        return 0.0
    return SPIN_TIME_S if environment.get("ROS_STATIC_PEERS") else REMOTE_S


def usual_spin_time_s(environment: Mapping[str, str] = os.environ) -> float:
    """How long a graph may take to be complete."""
    return SPIN_TIME_WITH_SERVER_S if environment.get("ROS_DISCOVERY_SERVER") else SPIN_TIME_S


def see_whole_graph(environment: MutableMapping[str, str] = os.environ) -> None:
    """Request all nodes from a discovery server, not only those that match this process.

    Call it before the participant is made. Nodes of users do not get that much.
    """
    if environment.get("ROS_DISCOVERY_SERVER") and not environment.get("ROS_SUPER_CLIENT"):
        environment["ROS_SUPER_CLIENT"] = "TRUE"


def has_profiles(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the user has profiles of Fast DDS."""
    return any(environment.get(name) for name in PROFILES) or any(
        Path(name).exists() for name in _PROFILES
    )


def is_plain(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether discovery is plain RTPS, so that `reader` can do it."""
    return (
        not any(environment.get(name) for name in _UNUSUAL)
        and not has_profiles(environment)
        and environment.get("RMW_IMPLEMENTATION", "") in _PLAIN_RMW
        and environment.get("FASTDDS_BUILTIN_TRANSPORTS", "") in _PLAIN_TRANSPORTS
        and environment.get("ROS_SECURITY_ENABLE") != "true"
        and not is_off(environment)
        and Path("/proc/net/udp").exists()
    )


def why_empty(domain_id: int) -> str:
    """The message for a graph without nodes: discovery is off, or other domains have some."""
    if is_off():
        return f"0 nodes on domain {domain_id}: {OFF}"
    place = " (localhost only)" if localhost_only() else ""
    sentence = f"0 nodes on domain {domain_id}{place}"
    others = sorted(d for d in participants_by_domain() if d != domain_id)
    if not others:
        return f"{sentence}; no other domain is in use on this machine"
    if len(others) == 1:
        return f"{sentence}; a run on domain {others[0]} is active: add --domain {others[0]}"
    names = ", ".join(map(str, others))
    return f"{sentence}; runs on domains {names} are active: add --domain {others[0]}"
