"""Prints the processes that a launch file would start; `smoke` runs this before a launch.

`python -m launcher.commands.launch.forecast WORDS`, with the words of a launch, prints one JSON
object, and nothing if the launch file cannot be planned.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from typing import Any

from launcher.commands import launch
from launcher.commands import plan as planning
from launcher.commands.launch.target import LaunchRequest
from launcher.control.selection import ProcessNames
from launcher.errors import ExitCode, LauncherError
from launcher.interpreter.trace import Visit
from launcher.language.actions.events import OpaqueFunction, RegisterEventHandler
from launcher.model.events import LoadRequest
from launcher.planner import Plan

_OURS = ("launch.", "launch_ros.", "launcher.")  # entities of others may do anything


def main(words: Sequence[str]) -> int:
    try:
        plan = planning.evaluate(LaunchRequest.of(launch.COMMAND.parse(words)))
    except LauncherError as error:
        return error.exit_code
    if plan.error is not None:
        return ExitCode.USAGE
    print(json.dumps(_document(plan)))
    return ExitCode.OK


def _document(plan: Plan) -> dict[str, Any]:
    named = [ProcessNames.of(process.spec) for process in plan.processes]
    return {
        "is_certain": is_certain(plan),
        "processes": [
            {
                "name": f"{one.label}-{number}",
                "label": one.label,
                "nodes": one.nodes,
                "namespace": one.namespace,
                # What an exit causes has no time: nobody knows when the process exits.
                "time_s": planned.stamp.time_s if planned.stamp.phase == "run" else None,
            }
            for number, (one, planned) in enumerate(zip(named, plan.processes, strict=True), 1)
        ],
        "components": [_component(load) for load, _ in plan.loads],
    }


def _component(load: LoadRequest) -> str | None:
    """The full name of its node; None if the component names it itself."""
    if load.name is None:
        return None
    return f"{(load.namespace or '').rstrip('/')}/{load.name}"


def is_certain(plan: Plan) -> bool:
    """Whether the plan covers everything that the launch file can do while it runs.

    Event handlers whose entities the plan has visited are covered; functions that are called with
    the exit or the output of a process may start anything.
    """
    visits = [visit for root in plan.visits for visit in root.walk()]
    seen = {id(visit.entity) for visit in visits}
    return not any(_is_open(visit, seen) for visit in visits)


def _is_open(visit: Visit, seen: set[int]) -> bool:
    entity = visit.entity
    if isinstance(entity, RegisterEventHandler):
        known = entity.event_handler.describe()[1]
        return not known or any(id(one) not in seen for one in known)
    if isinstance(entity, OpaqueFunction):
        return bool(visit.stamp.phase == "exit")
    if not type(entity).__module__.startswith(_OURS):
        return True
    return callable(getattr(entity, "_ExecuteLocal__on_exit", None))  # `on_exit` of a process


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
