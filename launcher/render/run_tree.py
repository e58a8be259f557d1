"""What a run has been asked for so far, as a tree for people: `plan` of a run that goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from launcher.render.command_line import command_line
from launcher.render.entities import short_path
from launcher.render.plan_tree import (
    identity,
    load_branch,
    moment,
    restart_line,
    transitions,
)
from launcher.render.tree import Branch

if TYPE_CHECKING:
    from launcher.planner import Plan, PlannedProcess


def run_tree(plan: Plan) -> Branch:
    """As `plan_tree`, of the plan that a run has become: it was not traced, so it has no groups."""
    arguments = [
        Branch(f"argument {name} = {value!r}", style="value")
        for name, value in plan.declared.items()
    ]
    processes = [_process(plan, process) for process in plan.processes]
    loads = [load_branch(load, stamp) for load, stamp in plan.loads]
    children = [*arguments, *processes, *loads, *transitions(plan)]
    return Branch(short_path(plan.path), style="scope", children=children)


def _process(plan: Plan, process: PlannedProcess) -> Branch:
    asides = [identity(process), moment(process.stamp.time_s)]
    if process.stamp.cause is not None:
        asides.append(f"after the end of {plan.processes[process.stamp.cause].spec.name}")
    # The parameter files are those of the run, which are there as long as it goes on.
    command = command_line(process.spec, plan.environment, {})
    return Branch(
        process.spec.name,
        style="process",
        aside=", ".join(text for text in asides if text),
        lines=[("command", f"$ {command}"), *restart_line(process)],
    )
