"""Warnings of more nodes than find each other; see `launcher.hosts.crowd`."""

from __future__ import annotations

import sys
from collections.abc import Container, Iterable, Mapping

from launcher.commands.launch.target import LaunchRequest
from launcher.hosts.crowd import too_many
from launcher.model.events import Effect, StartProcess
from launcher.model.spec import ProcessSpec
from launcher.planner import Plan, make_plan
from launcher.ros.discovery.ports import participants_by_domain
from launcher.stdio import silence


def warn_of_crowd(
    effects: Iterable[Effect],
    request: LaunchRequest,
    *,
    is_all: bool,
    absorbed: Container[str] = (),
) -> None:
    """Say which nodes would not find each other, those of timers included (unless `is_all`).

    `absorbed` are processes of the launch file that are none of their own.
    """
    specs = [effect.spec for effect in effects if isinstance(effect, StartProcess)]
    if not is_all:
        with silence():
            plan = make_plan(request.path, request.arguments)
        if plan.error is None:
            specs = of_run(plan)
    for message in crowds(spec for spec in specs if spec.name not in absorbed):
        print(f"warning: {message}", file=sys.stderr)


def of_run(plan: Plan) -> list[ProcessSpec]:
    """The processes that run at the same time, if none exits."""
    return [
        process.spec
        for process in plan.processes
        if process.stamp.phase == "run" and process.spec.name not in plan.absorbed
    ]


def crowds(specs: Iterable[ProcessSpec], wiring: Mapping[str, str] | None = None) -> list[str]:
    """Why some of these nodes would not find each other; `wiring` is what --discovery sets."""
    environments = [{**spec.env, **(wiring or {})} for spec in specs if spec.ros is not None]
    return too_many(environments, participants_by_domain())
