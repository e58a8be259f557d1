"""Warnings of more nodes than find each other; see `launcher.posix.crowd`."""

from __future__ import annotations

import os
import sys
from collections.abc import Container, Iterable, Mapping

from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec
from launcher.launch.plan.plan import Plan
from launcher.posix.crowd import too_many
from launcher.posix.ports import participants_by_domain

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.launch.launch_core import LaunchCore


def warn_of_crowd(core: LaunchCore, absorbed: Container[str]) -> None:
    """Say which nodes would not find each other, those of timers included.

    `absorbed` are processes of the launch file that are composed into another.
    """
    specs = [spec for spec in core.starts if spec.name not in absorbed]
    for one in core.later().processes:
        if one.is_likely and one.moment.cause is None:
            specs.append(replace(one.spec, env=dict(os.environ)))
    for message in crowds(specs):
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
