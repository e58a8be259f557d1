"""The checks of `doctor` about discovery: why nodes may not find each other."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.model.level import Level
from launcher.base.program import program
from launcher.base.text import count, several
from launcher.doctor.doctor_facts import Finding, NetworkFacts, ParticipantProcess
from launcher.posix.crowd import too_many

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_UDP = "FASTDDS_BUILTIN_TRANSPORTS"
_MAX_NODES = 4  # that are named


def check_network(facts: NetworkFacts) -> list[Finding]:
    """Findings, one or more of each name."""
    return [
        *_settings(facts),
        _loopback(facts),
        _multicast(facts),
        _shared_memory(facts),
        _other_nodes(facts),
        *_crowds(facts),
        _clock(facts),
    ]


def _settings(facts: NetworkFacts) -> Iterator[Finding]:
    """Variables with which nodes do not start, or that have no effect."""
    settings = facts.settings
    found = list(_mistakes(facts))
    for level, text, advice in found:
        yield Finding("discovery", level, text, advice)
    if not found:
        names = ("ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS", _RANGE)
        said = [f"{name}={settings[name]}" for name in names if name in settings]
        yield Finding("discovery", Level.OK, ", ".join(said) or "by multicast in the subnet")


def _mistakes(facts: NetworkFacts) -> Iterator[tuple[Level, str, str]]:
    settings = facts.settings
    reach = settings.get(_RANGE, "SUBNET")
    if facts.unknown_peers:
        names = ", ".join(facts.unknown_peers)
        text = f"ROS_STATIC_PEERS names {names}, which cannot be resolved: no node can start"
        yield Level.PROBLEM, text, "use IP addresses"
    if facts.unknown_servers:
        names = ", ".join(facts.unknown_servers)
        text = f"ROS_DISCOVERY_SERVER names {names}, which is no address: its nodes find no others"
        yield Level.PROBLEM, text, "ADDRESS:PORT, as in 10.0.0.2:11811; several with ';'"
    if settings.get("ROS_STATIC_PEERS"):
        if settings.get("ROS_LOCALHOST_ONLY") == "1":
            text = "with ROS_LOCALHOST_ONLY=1, ROS_STATIC_PEERS has no effect"
            yield Level.PROBLEM, text, f"unset ROS_LOCALHOST_ONLY, set {_RANGE}=LOCALHOST"
        elif reach in ("SYSTEM_DEFAULT", "OFF"):
            text = f"with {_RANGE}={reach}, ROS_STATIC_PEERS has no effect"
            yield Level.PROBLEM, text, f"{_RANGE}=LOCALHOST: nodes see their machine and the peers"
        elif reach == "SUBNET":
            text = f"with {_RANGE}=SUBNET, only the first 4 nodes of each peer are found"
            yield Level.NOTE, text, f"{_RANGE}=LOCALHOST: the first 32 are found"
    elif reach == "OFF":
        text = f"{_RANGE}=OFF: no node finds any other, not even on this machine"
        yield Level.PROBLEM, text, f"{_RANGE}=LOCALHOST, or SUBNET"


def _loopback(facts: NetworkFacts) -> Finding:
    if facts.loopback_fault is None:
        return Finding("loopback", Level.OK, "127.0.0.1 can be reached")
    text = (
        f"127.0.0.1 cannot be reached ({facts.loopback_fault}): nodes of this machine do not find "
        "each other, or only by another network"
    )
    return Finding("loopback", Level.PROBLEM, text, "as root: ip link set lo up; or the firewall")


def _multicast(facts: NetworkFacts) -> Finding:
    """Only on this machine; `hosts check` tests it between hosts."""
    name, settings = "multicast", facts.settings
    if not facts.addresses:
        return Finding(name, Level.OK, "there is no network besides this machine")
    if not facts.without_multicast:
        advice = f"between machines: {program()} hosts check"
        text = f"is sent and received on {', '.join(facts.addresses)}; {advice}"
        return Finding(name, Level.OK, text)
    text = f"a datagram to 239.255.0.1 is not received on {', '.join(facts.without_multicast)}"
    others = ("ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER", "ROS_LOCALHOST_ONLY")
    is_used = settings.get(_RANGE, "SUBNET") in ("SUBNET", "SYSTEM_DEFAULT")
    is_needed = is_used and not any(settings.get(other) for other in others)
    level = Level.PROBLEM if is_needed else Level.NOTE
    advice = "allow UDP to 239.255.0.1 in the firewall, or use --discovery peers or server"
    return Finding(name, level, f"{text}: nodes do not find each other by multicast", advice)


def _shared_memory(facts: NetworkFacts) -> Finding:
    """Containers with the network of this machine have its addresses."""
    name = "shared memory of nodes"
    apart = [
        node
        for node in facts.nodes
        if node.shares_memory is False and node.settings.get(_UDP) not in ("UDPv4", "UDPv6")
    ]
    if not apart or facts.settings.get(_UDP) in ("UDPv4", "UDPv6"):
        return Finding(name, Level.OK, "all nodes in this network share /dev/shm")
    text = (
        f"another /dev/shm, and the addresses of this machine: {_named(apart)} (containers with "
        "the network of their host?). Fast DDS uses shared memory between nodes here and there: "
        "messages are lost without a word"
    )
    advice = f"start the container with --ipc=host, or set {_UDP}=UDPv4 on both sides"
    return Finding(name, Level.PROBLEM, text, advice)


def _other_nodes(facts: NetworkFacts) -> Finding:
    """Running nodes that those of this shell would not see."""
    name, settings = "other nodes", facts.settings
    domain = settings.get("ROS_DOMAIN_ID", "0")
    wanted = settings.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    distro = settings.get("ROS_DISTRO")
    elsewhere = [node for node in facts.nodes if str(node.domain) != domain]
    same = [node for node in facts.nodes if str(node.domain) == domain]
    texts = []
    if elsewhere and not same:
        domains = ", ".join(sorted({str(node.domain) for node in elsewhere}))
        texts.append(f"ROS_DOMAIN_ID is {domain}, but running nodes use {domains}")
    for node in same:
        there = node.settings.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
        if there != wanted:
            texts.append(f"{_named([node])} uses {there}, and this shell {wanted}")
        its = node.settings.get("ROS_DISTRO")
        if distro and its and its != distro:
            texts.append(f"{_named([node])} is of ROS {its}, and this shell of {distro}")
    if not texts:
        return Finding(
            name, Level.OK, f"{count(len(same), 'process')} with nodes on domain {domain}"
        )
    advice = "nodes of this shell do not see them: set the variable to the same value"
    return Finding(name, Level.NOTE, "; ".join(texts), advice)


def _crowds(facts: NetworkFacts) -> Iterator[Finding]:
    """More nodes than find each other."""
    name = "number of nodes"
    environments = [{**one.settings, "ROS_DOMAIN_ID": str(one.domain)} for one in facts.nodes]
    messages = too_many(environments, {})
    for message in messages:
        text, _, advice = message.rpartition("; ")
        yield Finding(name, Level.PROBLEM, text, advice)
    if not messages:
        yield Finding(name, Level.OK, f"{count(len(facts.nodes), 'process')} with nodes")


def _named(nodes: list[ParticipantProcess]) -> str:
    return several([f"{node.command} [{node.pid}]" for node in nodes], _MAX_NODES)


def _clock(facts: NetworkFacts) -> Finding:
    if facts.is_in_step is not False:
        return Finding("clock", Level.OK, "is kept in step" if facts.is_in_step else "unknown")
    text = "no time service keeps the clock in step: ages of messages between machines are wrong"
    advice = f"chrony or systemd-timesyncd; {program()} hosts check compares clocks"
    return Finding("clock", Level.NOTE, text, advice)
