"""Whether a plan covers everything that a launch file can do."""

from __future__ import annotations

from typing import Any

from launcher.language.actions.events import OpaqueFunction, RegisterEventHandler
from launcher.language.interpreter.trace import Visit
from launcher.launch.plan.planner import Plan

_OURS = ("launch.", "launch_ros.", "launcher.")  # entities of others may do anything


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
        return visit.stamp.phase == "exit" and not is_own_function(entity)
    if not type(entity).__module__.startswith(_OURS):
        return True
    return callable(getattr(entity, "_ExecuteLocal__on_exit", None))  # `on_exit` of a process


def is_own_function(entity: Any) -> bool:
    """Whether the launcher created this entity itself, to handle an event."""
    function = vars(entity).get("_OpaqueFunction__function")
    module = getattr(function, "__module__", "") or ""
    return isinstance(entity, OpaqueFunction) and module.startswith("launcher.")
