"""The processes of a launch file on their hosts, with everything that is wrong about it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from launcher.base.errors import LauncherError
from launcher.base.model.events import LoadRequest
from launcher.base.model.record import Record, replace
from launcher.hosts.file.hosts_model import HostsFile
from launcher.hosts.file.order import order_for
from launcher.hosts.file.placement import Candidates, Component, Placement, PlacementFindings
from launcher.hosts.launching.shown import HERE, PlacedThere
from launcher.launch.plan.plan import Plan
from launcher.launch.plan.plan_certainty import is_certain

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.interpreter.later import Later
    from launcher.launch.launch_core import LaunchCore


class Placing(Record):
    """`placed` by the number of the process in the plan.

    `warnings` are about what is not sent to the hosts; a run prints them when a process starts.
    """

    placed: tuple[PlacedThere, ...]
    findings: PlacementFindings
    warnings: tuple[str, ...] = ()


def place(plan: Plan, file: HostsFile) -> Placing:
    """Where the processes of a plan run, and what runs there.

    The plan must have been made with scopes. What an order cannot carry is among the findings.
    """
    specs = tuple(process.spec for process in plan.processes)
    if plan.error is not None:
        return _placing(Candidates(specs=specs), file, plan.environment, with_rules=False)
    found = Candidates(
        specs=specs,
        off=plan.switched_off,
        components=_components(load for load, _ in plan.loads),
        is_complete=plan.is_off_complete and is_certain(plan),
    )
    return _placing(found, file, plan.environment)


def place_first(core: LaunchCore, later: Later, file: HostsFile) -> Placing:
    """The same for processes that a run starts in its first moment, with what comes `later`."""
    scopes = core.interpreter.host.scopes
    assert scopes is not None
    found = Candidates(
        specs=tuple(core.starts),
        later=tuple(one.spec for one in later.processes),
        off=tuple(scopes.off),
        components=_components([*core.loads, *later.loads]),
        is_complete=scopes.is_off_complete and later.is_complete,
    )
    return _placing(found, file, core.interpreter.environment)


def _placing(
    found: Candidates, file: HostsFile, environment: Mapping[str, str], *, with_rules: bool = True
) -> Placing:
    placement = Placement(file)
    findings = placement.check(found) if with_rules else PlacementFindings()
    errors: list[LauncherError] = list(findings.errors)
    warnings: list[str] = []
    placed: list[PlacedThere] = []
    for spec in found.specs:
        try:
            host = placement.host_of(spec)
            order = None
            if host is not None:
                order = order_for(spec, base=environment, warn=warnings.append)
            placed.append(PlacedThere(host=host, order=order))
        except LauncherError as error:
            placed.append(HERE)
            if all(error.render() != known.render() for known in errors):
                # Conflicts of rules are reported once for all processes.
                is_reported = error.where in {rule.where for rule in file.rules}
                errors += [] if findings.errors and is_reported else [error]
    known = (*file.warnings, *findings.warnings)
    return Placing(
        placed=tuple(placed),
        findings=replace(findings, errors=tuple(errors), warnings=known),
        warnings=tuple(dict.fromkeys(warnings)),
    )


def _components(loads: Iterable[LoadRequest]) -> tuple[Component, ...]:
    return tuple(
        Component(
            name=f"{(load.namespace or '').rstrip('/')}/{load.name or ''}",
            container=f"/{load.container.lstrip('/')}",
            package=load.package,
        )
        for load in loads
    )
