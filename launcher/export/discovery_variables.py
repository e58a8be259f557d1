"""The variables for discovery on each host, by the addresses of the hosts file."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterator, Sequence

from launcher.base.model.record import replace
from launcher.export.export_model import ExportedProcess, Unsupported
from launcher.hosts.discovery import PEERS, RANGE
from launcher.hosts.file.hosts_model import Discovery, DiscoveryMode

_WHAT = "discovery"


def with_discovery(
    processes: Sequence[ExportedProcess], discovery: Discovery
) -> tuple[ExportedProcess, ...]:
    """The processes with the variables of the mode, which those of their host override."""
    return tuple(
        replace(one, environment=dict(sorted({**one.environment, **variables}.items())))
        for one in processes
        for variables in [_variables(one, processes, discovery.mode)]
    )


def _variables(
    process: ExportedProcess, processes: Sequence[ExportedProcess], mode: DiscoveryMode | None
) -> dict[str, str]:
    if mode is DiscoveryMode.MULTICAST:
        found = {RANGE: "SUBNET"}
    elif mode is DiscoveryMode.PEERS:
        hosts = {one.host.name: one.host.address for one in processes if one.host is not None}
        own = process.host.name if process.host else None
        others = dict.fromkeys(address for name, address in hosts.items() if name != own)
        found = {RANGE: "LOCALHOST", PEERS: ";".join(others)}
    else:
        return {}
    set_there = process.host.environment if process.host else {}
    return {name: value for name, value in found.items() if name not in set_there}


def gaps(processes: Sequence[ExportedProcess], discovery: Discovery) -> Iterator[Unsupported]:
    """What the variables cannot do."""
    where = discovery.where.rpartition("/")[2] or "--discovery"
    if discovery.mode is DiscoveryMode.SERVER:
        text = "no discovery server is started, and no node is configured to use one"
        yield Unsupported(what=f"{_WHAT} server", place=where, text=text)
    if discovery.mode is DiscoveryMode.PEERS:
        names = tuple(one.unit for one in processes if one.host is None)
        if names and len(names) < len(processes):
            text = f"the hosts do not find them: add the address of their machine to {PEERS}"
            yield Unsupported(what=f"{_WHAT} peers", place=where, text=text, names=names)
        named = [one for one in processes if one.host and not _is_number(one.host.address)]
        for address in dict.fromkeys(one.host.address for one in named if one.host):
            text = "nodes end where this name cannot be resolved: give the number in the hosts file"
            yield Unsupported(what=f"address '{address}'", place=where, text=text)


def _is_number(address: str) -> bool:
    try:
        ipaddress.ip_address(address)
    except ValueError:
        return False
    return True
