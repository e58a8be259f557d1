"""The processes of a plan on their hosts, with everything that is wrong about it."""

from __future__ import annotations

from launcher.commands.launch.certainty import is_certain
from launcher.errors import LauncherError
from launcher.hosts.model import HostsFile
from launcher.hosts.order import order_for
from launcher.hosts.placement import Candidates, Component, Findings, Placement
from launcher.model.record import Record, replace
from launcher.planner import Plan
from launcher.render.hosts import HERE, Placed


class Placing(Record):
    """`placed` by the number of the process in the plan.

    `warnings` are about what is not sent to the hosts; a run tells them when a process starts.
    """

    placed: tuple[Placed, ...]
    findings: Findings
    warnings: tuple[str, ...] = ()


def place(plan: Plan, file: HostsFile) -> Placing:
    """Where the processes of a plan run, and what runs there.

    The plan must have been made with scopes. What an order cannot carry is among the findings.
    """
    placement = Placement(file)
    findings = placement.check(candidates(plan)) if plan.error is None else Findings()
    errors: list[LauncherError] = list(findings.errors)
    warnings: list[str] = []
    placed: list[Placed] = []
    for process in plan.processes:
        try:
            host = placement.host_of(process.spec)
            order = None
            if host is not None:
                order = order_for(process.spec, base=plan.environment, warn=warnings.append)
            placed.append(Placed(host=host, order=order))
        except LauncherError as error:
            placed.append(HERE)
            if all(error.render() != known.render() for known in errors):
                errors += [] if findings.errors and error.where in _places(file) else [error]
    told = (*file.warnings, *findings.warnings)
    return Placing(
        placed=tuple(placed),
        findings=replace(findings, errors=tuple(errors), warnings=told),
        warnings=tuple(dict.fromkeys(warnings)),
    )


def candidates(plan: Plan) -> Candidates:
    """What the rules of a hosts file are compared with."""
    return Candidates(
        specs=tuple(process.spec for process in plan.processes),
        off=plan.switched_off,
        components=tuple(
            Component(
                name=f"{(load.namespace or '').rstrip('/')}/{load.name or ''}",
                container=f"/{load.container.lstrip('/')}",
                package=load.package,
            )
            for load, _ in plan.loads
        ),
        is_complete=plan.is_off_complete and is_certain(plan),
    )


def _places(file: HostsFile) -> set[str]:
    """Conflicts of rules are told once for all processes."""
    return {rule.where for rule in file.rules}
