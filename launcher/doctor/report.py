"""`doctor --report`: what there is on this machine and in the ROS graph, for a report of a problem.

The sections are those of `ros2 doctor --report`.
"""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Iterable, Iterator, Mapping

import launcher
from launcher.base.errors import PackageNotFoundError
from launcher.base.model.record import Record
from launcher.doctor.network_facts import collect_network
from launcher.packages import distribution, finder, reading_once
from launcher.packages.extras import DISTRIBUTION
from launcher.ros.snapshot.qos_matching import mismatches
from launcher.ros.snapshot.ros_graph import Direction, GraphSnapshot, is_hidden
from launcher.ros.topics.listing import listed

WARNING = "This report has names, addresses, paths and variables of this machine: read it first."
_VERSION = re.compile(r"<version[^>]*>\s*([^<\s]+)")
_SECRET = re.compile(r"TOKEN|SECRET|PASSWORD")
# Whose variables are shown, under the titles of `ros2 doctor`.
_PREFIXES = {
    "ROS environment variables": ("ROS_", "AMENT_", "COLCON_", "CMAKE_PREFIX_PATH"),
    "rcutils environment variables": ("RCUTILS_",),
    "rmw environment variables": ("RMW_", "FASTRTPS_", "FASTDDS_", "CYCLONEDDS_", "ZENOH_"),
    "launcher environment variables": ("LAUNCHER_",),
}
Entries = list[tuple[str, str]]


class ReportSection(Record):
    """A title, and (name, value) below it."""

    title: str
    entries: tuple[tuple[str, str], ...]

    def document(self) -> dict[str, object]:
        found = [{"name": name, "value": value} for name, value in self.entries]
        return {"title": self.title.lower(), "entries": found}


@reading_once()
def report(env: Mapping[str, str], graph: GraphSnapshot) -> list[ReportSection]:
    """All sections; `env` is the environment of a run."""
    found = {
        "PLATFORM INFORMATION": _platform(),
        "ROS 2 INFORMATION": _ros(env),
        "ROS ENVIRONMENT": list(_environment(env)),
        "NETWORK CONFIGURATION": list(_network(env)),
        "PACKAGE VERSIONS": list(_packages(env)),
        "NODE LIST": [("node", name) for name in graph.nodes],
        "QOS COMPATIBILITY LIST": list(_qos(graph)),
        "TOPIC LIST": list(_topics(graph)),
        "SERVICE LIST": list(_services(graph)),
        "ACTION LIST": list(_actions(graph)),
    }
    return [ReportSection(title, tuple(entries)) for title, entries in found.items()]


def as_text(sections: Iterable[ReportSection]) -> str:
    lines = [WARNING]
    for section in sections:
        width = max((len(name) for name, _ in section.entries), default=0)
        lines += ["", f"   {section.title}"]
        lines += [f"{name:<{width}} : {value}" for name, value in section.entries] or ["none"]
    return "\n".join(lines)


def _platform() -> Entries:
    system = platform.uname()
    return [
        ("system", f"{system.system} {system.release}"),
        ("version", system.version),
        ("machine", system.machine),
        ("processors", str(os.cpu_count())),
        ("libc", " ".join(filter(None, platform.libc_ver())) or "unknown"),
        ("Python", f"{platform.python_version()} ({platform.python_implementation()})"),
    ]


def _ros(env: Mapping[str, str]) -> Entries:
    folder = os.path.dirname(launcher.__file__)
    return [
        ("ROS", distribution.title(env)),
        ("middleware", env.get("RMW_IMPLEMENTATION") or "rmw_fastrtps_cpp (default)"),
        (DISTRIBUTION, f"{launcher.__version__} ({folder})"),
    ]


def _environment(env: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    for title, prefixes in _PREFIXES.items():
        names = sorted(name for name in env if name.startswith(prefixes))
        found = [f"{name}={'...' if _SECRET.search(name) else env[name]}" for name in names]
        yield title, ", ".join(found) or "none"


def _network(env: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    facts = collect_network(env)
    for address in facts.addresses:
        multicast = "no" if address in facts.without_multicast else "yes"
        yield address, f"multicast: {multicast}"
    for node in facts.nodes:
        yield f"participant in domain {node.domain}", f"pid {node.pid}, {node.command}"


def _packages(env: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    for name in sorted(finder.package_names(env)):
        try:
            manifest = finder.share_directory(name, env) / "package.xml"
            found = _VERSION.search(manifest.read_text(encoding="utf-8"))
        except (OSError, ValueError, PackageNotFoundError):
            found = None
        yield name, found[1] if found else "unknown"


def _qos(graph: GraphSnapshot) -> Iterator[tuple[str, str]]:
    for topic in graph.topic_types():
        for found in mismatches(graph.endpoints(topic)):
            names = ", ".join(one.shown_node for one in found.publishers)
            why = "; ".join(
                f"{fault.policy} {fault.offered} is offered, {fault.requested} requested"
                for fault in found.faults
            )
            yield topic, f"{found.subscription.shown_node} receives nothing from {names}: {why}"


def _topics(graph: GraphSnapshot) -> Iterator[tuple[str, str]]:
    for one in listed(graph, hidden=False):
        yield one.label, f"publishers {one.publishers}, subscriptions {one.subscriptions}"


def _services(graph: GraphSnapshot) -> Iterator[tuple[str, str]]:
    for name, types in graph.service_types().items():
        if not is_hidden(name):
            users = f"servers {len(graph.servers(name))}, clients {len(graph.clients(name))}"
            yield f"{name} [{', '.join(types)}]", users


def _actions(graph: GraphSnapshot) -> Iterator[tuple[str, str]]:
    for name, types in graph.action_types().items():
        feedback = f"{name}/_action/feedback"
        servers = len(graph.on(feedback, Direction.PUBLISHER))
        clients = len(graph.on(feedback, Direction.SUBSCRIPTION))
        yield f"{name} [{', '.join(types)}]", f"servers {servers}, clients {clients}"
