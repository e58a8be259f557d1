"""What is wrong between hosts: settings that differ, and what does not reach whom."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence

from launcher.base.model.level import Level
from launcher.base.text import count
from launcher.hosts.check.host_findings import CheckedHost, HostFinding, Survey
from launcher.hosts.check.host_judges import sync_command
from launcher.hosts.file.hosts_model import LOCAL, DiscoveryMode
from launcher.packages.distribution import WHEEL_MACHINES, of_version, or_default

DEFAULT_MIDDLEWARE = "rmw_fastrtps_cpp"
_UDP = "FASTDDS_BUILTIN_TRANSPORTS"


def check_pairs(survey: Survey, mode: DiscoveryMode | None) -> list[HostFinding]:
    """All findings about two hosts or more."""
    return [
        *_versions(survey),
        *_differences(survey),
        *_shared_memory(survey),
        *_unreached(survey, mode),
        *_translated(survey),
    ]


def domain_of(member: CheckedHost) -> str:
    return member.settings.get("ROS_DOMAIN_ID", "0")


def middleware_of(member: CheckedHost) -> str:
    installed = member.facts["middlewares"]
    usual = DEFAULT_MIDDLEWARE if DEFAULT_MIDDLEWARE in installed or not installed else installed[0]
    return member.settings.get("RMW_IMPLEMENTATION", usual)


def distro_of(member: CheckedHost) -> str | None:
    """The ROS distribution; None if there is no ROS."""
    version = member.facts["rclpy"]
    if version is None:
        return member.settings.get("ROS_DISTRO")
    return of_version(version) or f"rclpy {version}"


# ---- software and settings


def _versions(survey: Survey) -> Iterator[HostFinding]:
    """The agent must use the protocol of the launcher here."""
    ours = survey.members[LOCAL].facts
    for member in survey.reached:
        facts = member.facts
        if facts["version"] in (None, ours.get("version")):
            if facts["version"] is not None and facts["code"] != ours.get("code"):
                text = "its launcher is another state of the same version: a run may fail there"
                advice = f"{sync_command(member)} brings that of this machine"
                yield _finding("launcher", [member.name], text, advice)
            continue
        text = f"launcher {facts['version']} is installed, and {ours.get('version')} runs here"
        level = Level.NOTE
        if facts["protocol"] != ours.get("protocol"):
            text += ": they use different protocols"
            level = Level.PROBLEM
        advice = f"{sync_command(member)} brings the same"
        yield _finding("launcher", [member.name], text, advice, level)


def _differences(survey: Survey) -> Iterator[HostFinding]:
    for member in survey.reached:
        wanted = middleware_of(member)
        if member.facts["middlewares"] and wanted not in member.facts["middlewares"]:
            yield _finding(
                "middleware",
                [member.name],
                f"RMW_IMPLEMENTATION is {wanted}, which is not installed: no node can start",
                f"installed there: {', '.join(member.facts['middlewares'])}",
            )
        if member.name != LOCAL and distro_of(member) is None:
            text = f"{member.facts['executable']} finds no ROS: no rclpy"
            advice = f"set `setup: /opt/ros/{or_default()}/setup.sh`"
            if member.facts["machine"] in WHEEL_MACHINES:
                advice += ", or install the wheels: hosts sync"
            yield _finding("distro", [member.name], text, advice)
    yield from _different(
        survey,
        "domain",
        {one.name: domain_of(one) for one in survey.reached},
        "ROS_DOMAIN_ID is {values}: their nodes do not see each other",
        "set it once, here: it is passed on; remove it from `env` and from files of `setup`",
    )
    yield from _different(
        survey,
        "middleware",
        {one.name: middleware_of(one) for one in survey.reached},
        "the middleware is {values}: they may not see each other, and services fail",
        "set RMW_IMPLEMENTATION once, here: it is passed on",
    )
    distros = {one.name: distro for one in survey.reached if (distro := distro_of(one))}
    yield from _different(
        survey,
        "distro",
        distros,
        "the ROS distribution is {values}: messages whose definitions differ are lost, and "
        "services may fail, both without an error",
        "use one distribution everywhere (`setup`, `python`)",
    )


def _different(
    survey: Survey, check: str, values: Mapping[str, str], text: str, advice: str
) -> Iterator[HostFinding]:
    """One finding if not all are the same."""
    groups: dict[str, list[str]] = {}
    for name, value in values.items():
        groups.setdefault(value, []).append(name)
    if len(groups) < 2:
        return
    listed = ", ".join(f"{value} on {' and '.join(names)}" for value, names in groups.items())
    yield _finding(check, values, text.format(values=listed), advice)


# ---- shared memory


def _shared_memory(survey: Survey) -> Iterator[HostFinding]:
    """Fast DDS takes hosts with the same addresses for one, and uses shared memory between them."""
    for one, other in itertools.combinations(survey.reached, 2):
        if not looks_like(one, other) or _shares_memory(one, other):
            continue
        if any(_avoids_memory(member) for member in (one, other)):
            continue
        text = (
            f"both have the addresses {', '.join(one.facts['addresses'])}, but not the same "
            "/dev/shm (containers with the network of their host?): Fast DDS takes them for one "
            "machine, and messages between them are lost without a word"
        )
        advice = f"set {_UDP}=UDPv4 for both, or let them share /dev/shm (--ipc=host)"
        yield _finding("shared memory", [one.name, other.name], text, advice)


def looks_like(one: CheckedHost, other: CheckedHost) -> bool:
    """Whether Fast DDS takes the two for one machine."""
    return bool(one.facts["addresses"]) and one.facts["addresses"] == other.facts["addresses"]


def _shares_memory(one: CheckedHost, other: CheckedHost) -> bool:
    names = ("boot_id", "shared_memory")
    return all(one.facts[name] == other.facts[name] for name in names)


def _avoids_memory(member: CheckedHost) -> bool:
    is_fast_dds = middleware_of(member).startswith("rmw_fastrtps")
    return not is_fast_dds or member.settings.get(_UDP) in ("UDPv4", "UDPv6")


# ---- the network


def _unreached(survey: Survey, mode: DiscoveryMode | None) -> Iterator[HostFinding]:
    no_unicast = survey.lost("unicast")
    if no_unicast:
        first = next(one for one in survey.reached if one.name == no_unicast[0][1])
        port = first.facts["ports"].get("unicast", 7410)
        yield _finding(
            "discovery",
            _names(no_unicast),
            f"UDP to port {port} does not get through: {_arrows(no_unicast)}. Nodes may see each "
            "other, but messages need it",
            f"open UDP from port {port // 250 * 250 + 150} to {port // 250 * 250 + 399} in the "
            "firewalls",
        )
    yield from _without_multicast(survey, mode, no_unicast)
    servers = [one.name for one in survey.reached if "server" in one.facts["ports"]]
    no_server = survey.lost("server", servers)
    if no_server:
        text = f"the port of the discovery server is not reached: {_arrows(no_server)}"
        advice = "open it in the firewall, or use another `server` or `port` of `discovery`"
        yield _finding("discovery", _names(no_server), text, advice)


def _without_multicast(
    survey: Survey, mode: DiscoveryMode | None, no_unicast: Sequence[tuple[str, str]]
) -> Iterator[HostFinding]:
    """Pairs that unicast does not reach either are left out: they have a finding."""
    lost = [pair for pair in survey.lost("multicast") if pair not in no_unicast]
    needs = [pair for pair in lost if not all(_has_substitute(survey, name) for name in pair)]
    if not needs or mode in (DiscoveryMode.PEERS, DiscoveryMode.SERVER):
        return
    yield _finding(
        "discovery",
        _names(needs),
        f"multicast is blocked: {_arrows(needs)}. Their nodes do not find each other",
        "--discovery peers (up to 32 nodes on a host) or --discovery server",
    )


def _has_substitute(survey: Survey, name: str) -> bool:
    settings = survey.members[name].settings
    return any(settings.get(one) for one in ("ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER"))


def _translated(survey: Survey) -> Iterator[HostFinding]:
    """Behind a jump host or a translating router, a host sees another address than ours."""
    operator = survey.members[LOCAL]
    own = operator.facts.get("addresses", ())
    for member in survey.reached:
        client = member.facts.get("client")
        if client and "." in client and client not in own and not client.startswith("127."):
            yield _finding(
                "discovery",
                [member.name],
                f"it sees this machine as {client}, which is no address of this machine (a jump "
                "host, or a router that translates addresses): its nodes cannot answer ours",
                "start no nodes here (place all on hosts), or connect by a VPN",
                Level.NOTE,
            )


def _names(pairs: Iterable[tuple[str, str]]) -> list[str]:
    return list(dict.fromkeys(name for pair in pairs for name in pair))


def _arrows(pairs: Sequence[tuple[str, str]]) -> str:
    """`a -> b, a <-> c`; only the first few."""
    found = []
    for sender, receiver in pairs:
        if (receiver, sender) not in pairs:
            found.append(f"{sender} -> {receiver}")
        elif sender < receiver:
            found.append(f"{sender} <-> {receiver}")
    more = f" and {count(len(found) - 6, 'more pair')}" if len(found) > 6 else ""
    return ", ".join(found[:6]) + more


def _finding(
    check: str, names: Iterable[str], text: str, advice: str, level: Level = Level.PROBLEM
) -> HostFinding:
    return HostFinding(check=check, hosts=tuple(names), level=level, text=text, advice=advice)
