"""Which hosts a run needs, by a dry run of its launch file and its hosts file, and how nodes find
each other.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Iterable

from launcher.commands.launch.placing import place
from launcher.commands.launch.target import LaunchRequest
from launcher.commands.launch.time_limit import limited
from launcher.document.reader import together
from launcher.engine.hosts.fleet import FleetPlan
from launcher.errors import UsageError
from launcher.hosts import discovery, discovery_server
from launcher.hosts.changes import changed
from launcher.hosts.file import read
from launcher.hosts.model import LOCAL, Discovery, DiscoveryMode, Host, HostsFile
from launcher.hosts.placement import Placement
from launcher.model.options import RunOptions
from launcher.model.record import Record
from launcher.model.spec import ProcessSpec, RestartMode, RestartPolicy
from launcher.planner import make_plan
from launcher.stdio import silence


class Preparation(Record):
    """What a run does about other hosts; `services` are processes of ours that it starts first."""

    fleet: FleetPlan | None = None
    services: tuple[ProcessSpec, ...] = ()


def prepare(request: LaunchRequest, options: RunOptions) -> Preparation:
    """Read the hosts file, and set the variables for discovery.

    LauncherError for a mistake in the file, before anything is started.
    """
    if options.hosts is None:
        wiring = _wire(Discovery().by(options.discovery), ())
        return Preparation(services=_services(wiring))
    file = changed(read(options.hosts), options.discovery, options.skip_hosts)
    placement = Placement(file)
    wanted = file.discovery
    specs = _planned(request, file)
    _check_required(options, placement, specs)
    _warn_of_many(wanted, placement, specs)
    needed = _needed(file, wanted, placement, specs)
    wiring = _wire(wanted, needed)
    environments = {host.name: wiring.environment_of(host.name) for host in needed}
    servers = {one.name: file.hosts.get(one.host) for one in wiring.servers}

    def host_of(spec: ProcessSpec) -> Host | None:
        return servers[spec.name] if spec.name in servers else placement.host_of(spec)

    title = " ".join([os.path.basename(request.path), *map(":=".join, request.arguments)])
    fleet = FleetPlan(host_of=host_of, needed=needed, environments=environments, title=title)
    return Preparation(fleet=fleet, services=_services(wiring))


def _planned(request: LaunchRequest, file: HostsFile) -> list[ProcessSpec]:
    """The processes that the launch file would start; an error in it is reported by the run.

    LauncherError with what is wrong about their places.
    """
    with limited(request.time_limit, request.path), silence():
        plan = make_plan(request.path, request.arguments, with_scopes=True)
        findings = place(plan, file).findings
    for warning in findings.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if findings.errors:
        raise together(findings.errors)
    return [process.spec for process in plan.processes]


def _check_required(
    options: RunOptions, placement: Placement, specs: Iterable[ProcessSpec]
) -> None:
    """UsageError if one is required whose host is skipped."""
    for spec in specs:
        host = placement.host_of(spec)
        if host is not None and host.is_skipped and options.is_required(spec):
            message = f"{spec.name} is required, and its host, '{host.name}', is skipped"
            hint = f"leave out --required, or --skip-host, or place {spec.name} elsewhere"
            raise UsageError(message, hint=hint)


def _warn_of_many(wanted: Discovery, placement: Placement, specs: Iterable[ProcessSpec]) -> None:
    """Each process of a node is at least one participant."""
    if wanted.mode is not DiscoveryMode.PEERS:
        return
    hosts = (placement.host_of(spec) for spec in specs if spec.ros is not None)
    counts = Counter(LOCAL if host is None else host.name for host in hosts)
    for name, number in counts.items():
        if number > discovery.MAX_WITH_PEERS:
            print(
                f"warning: {number} nodes on {name}: with peers, only "
                f"{discovery.MAX_WITH_PEERS} of a host are found by other hosts; "
                "--discovery server has no such limit",
                file=sys.stderr,
            )


def _needed(
    file: HostsFile, wanted: Discovery, placement: Placement, specs: Iterable[ProcessSpec]
) -> tuple[Host, ...]:
    found = [placement.host_of(spec) for spec in specs]
    if wanted.mode is DiscoveryMode.SERVER:
        found += [file.hosts.get(name) for name in (wanted.server, wanted.backup or "")]
    used = [host for host in found if host is not None and not host.is_skipped]
    return tuple({host.name: host for host in used}.values())


def _wire(wanted: Discovery, hosts: tuple[Host, ...]) -> discovery.Wiring:
    """The variables for discovery on each host; those of this machine are set."""
    domain = os.environ.get("ROS_DOMAIN_ID", "")
    wiring = discovery.wire(wanted, hosts, domain=domain)
    os.environ.update({**wiring.environment_of(), **wiring.profile(os.environ)})
    return wiring


def _services(wiring: discovery.Wiring) -> tuple[ProcessSpec, ...]:
    """The discovery servers; UsageError if there is no program for one that runs here."""
    for server in wiring.servers:
        if server.host == LOCAL and discovery_server.find(os.environ, sys.prefix) is None:
            raise UsageError(
                f"the discovery server is not installed: there is no {discovery_server.PROGRAM}",
                hint="pip install ros-fastrtps; or source a ROS 2 installation",
            )
    return tuple(map(_service, wiring.servers))


def _service(server: discovery.Server) -> ProcessSpec:
    words = (sys.executable, "-m", "launcher.hosts.discovery_server", *server.arguments)
    restart = RestartPolicy(mode=RestartMode.ALWAYS, delay_s=discovery.RESTART_DELAY_S)
    return ProcessSpec(
        name=server.name,
        label=server.name,
        argv=words,
        env=dict(os.environ),
        restart=restart,
        place="--discovery",
    )
