"""Prints the processes that a launch file would start; `smoke` runs this before a launch.

`python -m launcher.commands.launch.forecast WORDS`, with the words of a launch, prints one JSON
object, and nothing if the launch file cannot be planned.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import Any

from launcher.commands.launch.certainty import is_certain
from launcher.commands.launch.planned import print_planned
from launcher.control.selection import ProcessNames
from launcher.interpreter.trace import Visit
from launcher.language.events.launch import IncludeLaunchDescription, TimerEvent
from launcher.model.events import LoadRequest
from launcher.planner import Plan, Stamp

_ANY_TIME: dict[str, Any] = {"time_s": None, "cause": None}


def _document(plan: Plan) -> dict[str, Any]:
    named = [ProcessNames.of(process.spec) for process in plan.processes]
    delayed = {
        number + 1
        for root in filter(_is_delayed, plan.visits)
        for visit in root.walk()
        for number in visit.processes
    }
    return {
        "is_certain": is_certain(plan),
        "processes": [
            {
                "name": f"{one.label}-{number}",
                "label": one.label,
                "nodes": one.nodes,
                "namespace": one.namespace,
                "moment": _ANY_TIME if number in delayed else _moment(planned.stamp, named),
            }
            for number, (one, planned) in enumerate(zip(named, plan.processes, strict=True), 1)
        ],
        "components": [_component(load) for load, _ in plan.loads],
        "conditions": list(_conditions(plan, named)),
    }


def _is_delayed(root: Visit) -> bool:
    """Whether it comes some time after an exit."""
    return root.stamp.phase != "run" and isinstance(root.event, TimerEvent)


def _moment(stamp: Stamp, named: Sequence[ProcessNames]) -> dict[str, Any]:
    """When: what an exit causes has no time, since nobody knows when the process exits."""
    if stamp.phase == "run":
        return {"time_s": stamp.time_s, "cause": None}
    return {"time_s": None, "cause": None if stamp.cause is None else named[stamp.cause].label}


def _conditions(plan: Plan, named: Sequence[ProcessNames]) -> Iterator[dict[str, Any]]:
    """When conditions are evaluated that were false here, and may be true in a run.

    Those that are evaluated at the start are not.
    """
    for root in plan.visits:
        if not any(visit.skipped for visit in root.walk()):
            continue
        is_known = root.stamp.phase != "run" or isinstance(root.event, TimerEvent)
        if is_known and not _is_delayed(root):
            yield _moment(root.stamp, named)
        elif not isinstance(root.event, IncludeLaunchDescription):
            yield _ANY_TIME


def _component(load: LoadRequest) -> str | None:
    """The full name of its node; None if the component names it itself."""
    if load.name is None:
        return None
    return f"{(load.namespace or '').rstrip('/')}/{load.name}"


if __name__ == "__main__":
    sys.exit(print_planned(sys.argv[1:], _document))
