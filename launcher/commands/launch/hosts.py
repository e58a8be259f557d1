"""Which hosts a run needs, by a dry run of its launch file and its hosts file."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable

from launcher.commands.launch.placing import place
from launcher.commands.launch.target import LaunchRequest
from launcher.commands.launch.time_limit import limited
from launcher.document.reader import together
from launcher.engine.hosts.fleet import FleetPlan
from launcher.hosts import discovery
from launcher.hosts.file import read
from launcher.hosts.model import Discovery, DiscoveryMode, Host, HostsFile
from launcher.hosts.placement import Placement
from launcher.model.options import RunOptions
from launcher.model.record import replace
from launcher.model.spec import ProcessSpec
from launcher.planner import make_plan
from launcher.stdio import silence


def prepare(request: LaunchRequest, options: RunOptions) -> FleetPlan | None:
    """Read the hosts file, and set the variables for discovery; None if there is no file.

    LauncherError for a mistake in the file, before anything is started.
    """
    if options.hosts is None:
        _wire(Discovery(), options, ())
        return None
    file = read(options.hosts)
    placement = Placement(file)
    needed = _needed(placement, _planned(request, file))
    wiring = _wire(file.discovery, options, needed)
    environments = {host.name: wiring.environment_of(host.name) for host in needed}
    return FleetPlan(host_of=placement.host_of, needed=needed, environments=environments)


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


def _needed(placement: Placement, specs: Iterable[ProcessSpec]) -> tuple[Host, ...]:
    found = (placement.host_of(spec) for spec in specs)
    return tuple({host.name: host for host in found if host is not None}.values())


def _wire(wanted: Discovery, options: RunOptions, hosts: tuple[Host, ...]) -> discovery.Wiring:
    """The variables for discovery on each host; those of this machine are set."""
    if options.discovery is not None:
        wanted = replace(wanted, mode=DiscoveryMode(options.discovery))
    wiring = discovery.wire(wanted, hosts)
    os.environ.update(wiring.environment_of())
    return wiring
