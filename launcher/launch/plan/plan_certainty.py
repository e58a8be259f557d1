"""Whether a plan covers everything that a launch file can do, and so which names are certain."""

from __future__ import annotations

from typing import Any

from launcher.language.actions.event_actions import OpaqueFunction, RegisterEventHandler
from launcher.language.interpreter.trace import Visit
from launcher.launch.plan.plan import Occasion, Plan, Stamp

TYPE_CHECKING = False
if TYPE_CHECKING:
    # The events that lead to a stamp, first the start (None): each with the time of what it was
    # that the next one is about.
    Chain = list[tuple[Occasion | None, float]]


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


def process_names(plan: Plan) -> list[str]:
    """By the index of the process: `robot_3-5`, or `robot_3` if its number is not known.

    A process gets its number when it is requested. Which one comes first is known of what the
    launch file and its timers start, and of what one event causes.
    """
    chains = [_chain(process.stamp) for process in plan.processes]
    is_complete = is_certain(plan)
    return [
        process.spec.name
        if _is_known(chain, chains, is_complete=is_complete)
        else process.spec.label
        for process, chain in zip(plan.processes, chains, strict=True)
    ]


def _chain(stamp: Stamp) -> Chain:
    chain: Chain = [(stamp.occasion, stamp.time_s)]
    while stamp.occasion is not None:
        stamp = stamp.occasion.before
        chain.append((stamp.occasion, stamp.time_s))
    return chain[::-1]


def _is_known(chain: Chain, others: list[Chain], *, is_complete: bool) -> bool:
    if chain == [(None, 0.0)]:
        return True  # the rest comes later
    return is_complete and all(_have_order(chain, other) for other in others)


def _have_order(one: Chain, two: Chain) -> bool:
    """Whether it is known which comes first."""
    for (occasion, time_s), (other, other_s) in zip(one, two, strict=False):
        if occasion is not other:
            return False
        first, second = (time_s, other_s) if len(one) <= len(two) else (other_s, time_s)
    return len(one) == len(two) or first <= second
