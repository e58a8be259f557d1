"""What a launch file and its supervision file do that files for another supervisor cannot do."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.supervision import rule_for
from launcher.export.export_model import Unsupported
from launcher.language.actions.event_actions import (
    EmitEvent,
    Log,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launcher.language.actions.process import ExecuteLocal
from launcher.language.actions.timer import RosTimer
from launcher.language.events.process import ProcessExited
from launcher.language.ros.composition import ComposableNodeContainer, LoadComposableNodes
from launcher.language.ros.lifecycle import LifecycleTransition
from launcher.launch.plan.entities import handler_target

if TYPE_CHECKING:
    from launcher.base.model.spec import ProcessSpec
    from launcher.language.interpreter.trace import Visit
    from launcher.launch.plan.plan import Plan, PlannedProcess

_LOADERS = (ComposableNodeContainer, LoadComposableNodes)
_NO_HANDLER = "nothing reacts to it; what it starts or stops is left out"
THE_FILE = "the launch file"


class Places:
    """Names files relative to the folder of the launch file; others by their name only."""

    def __init__(self, launch_file: str) -> None:
        self._folder = os.path.dirname(os.path.abspath(launch_file)) + os.sep

    def of_entity(self, entity: object) -> str:
        """`file:line` of an entity of a launch file."""
        origin = getattr(entity, "_origin", None)
        return THE_FILE if origin is None else self.of_text(f"{origin.path}:{origin.line}")

    def of_text(self, place: str) -> str:
        """As `of_entity`, of `path:line`."""
        if place.startswith(self._folder):
            return place[len(self._folder) :]
        return os.path.basename(place) or THE_FILE


def gaps_of(plan: Plan, places: Places, names: Mapping[int, str]) -> Iterator[Unsupported]:
    """In the order of the launch file; the processes that are left out come last.

    `names` are those of exported processes, by their number in the plan.
    """
    seen: set[int] = set()
    for visit in _visits(plan):
        if id(visit.entity) not in seen:
            seen.add(id(visit.entity))
            yield from _of_visit(plan, visit, places, names)
    yield from _components(plan, places)
    yield from _transitions(plan, places)
    yield from _left_out(plan, places)


def _visits(plan: Plan) -> Iterator[Visit]:
    """All visits, except below actions that are reported as a whole."""
    waiting = list(reversed(plan.visits))
    while waiting:
        visit = waiting.pop()
        if visit.skipped:
            continue
        yield visit
        if not isinstance(visit.entity, LifecycleTransition):
            waiting += reversed(visit.children)


def settings_gaps(
    options: RunOptions, named: Iterable[tuple[ProcessSpec, str]], places: Places
) -> Iterator[Unsupported]:
    """What supervision files say of these processes, each with its unit, besides their policies."""
    of_names = dict(options.file_names)
    for action in options.fault_actions:
        text = f"nobody watches: no fault leads to '{action.text}'"
        yield Unsupported("on", places.of_text(action.where), text)
    for spec, unit in named:
        rule = rule_for(options.start_rules, spec)
        where = places.of_text(rule.where)
        if rule.after is not None and rule.after.names:
            text = f"it starts without waiting for {', '.join(rule.after.names)}"
            yield Unsupported("after", places.of_text(rule.after_where), text, (unit,))
        if rule.ready_when:
            yield Unsupported("ready_when", where, "nothing looks whether it is ready", (unit,))
        if rule.restart_with:
            text = f"it is not restarted with {', '.join(rule.restart_with)}"
            yield Unsupported("restart_with", where, text, (unit,))
        for budget in options.file_budgets:
            if matches(budget.pattern, spec):
                text = "nothing is done if it needs more than its budget"
                place = places.of_text(of_names.get(budget.pattern, ""))
                yield Unsupported("budget", place, text, (unit,))


def is_exported(process: PlannedProcess) -> bool:
    """Whether it starts at once, or by a timer, not after the exit of another."""
    return process.stamp.phase == "run" and _cause(process) is None


def _cause(process: PlannedProcess) -> int | None:
    """The index of the process after whose exit it starts."""
    origin = process.stamp.origin
    if origin is not None and isinstance(origin.event, ProcessExited):
        return origin.process
    return process.stamp.cause


def _of_visit(
    plan: Plan, visit: Visit, places: Places, names: Mapping[int, str]
) -> Iterator[Unsupported]:
    entity, where = visit.entity, places.of_entity(visit.entity)
    is_first = visit.stamp.phase == "run"
    match entity:
        case RegisterEventHandler():
            yield _handler(plan, entity.event_handler, where, names)
        case Shutdown() if is_first:
            yield Unsupported(what="Shutdown", place=where, text="the processes run on")
        case EmitEvent() if is_first and not _changes_state(entity):
            what = f"EmitEvent {type(entity.event).__name__}"
            yield Unsupported(what=what, place=where, text="no such event is sent")
        case OpaqueFunction() if _is_of_user(entity):
            yield _function(entity, where, is_first=is_first)
        case Log() if is_first:
            text = "the message is not printed"
            yield Unsupported(what=type(entity).__name__, place=where, text=text, is_note=True)
        case RosTimer():
            text = "its delay is real time, not that of a simulation"
            yield Unsupported(what="RosTimer", place=where, text=text)
        case ExecuteLocal() if getattr(entity, "_ExecuteLocal__on_exit", None) is not None:
            about = tuple(names[number] for number in visit.processes if number in names)
            yield Unsupported(
                what="on_exit", place=where, text="its exit causes nothing", names=about
            )


def _handler(plan: Plan, handler: object, where: str, names: Mapping[int, str]) -> Unsupported:
    target, _ = handler_target(handler)
    about = {
        names[number]: None
        for visit in _visits(plan)
        if visit.entity is target
        for number in visit.processes
        if number in names
    }
    return Unsupported(
        what=type(handler).__name__, place=where, text=_NO_HANDLER, names=tuple(about)
    )


def _changes_state(entity: EmitEvent) -> bool:
    return type(entity.event).__name__ == "ChangeState"


def _is_of_user(entity: OpaqueFunction) -> bool:
    module = getattr(entity._function_called, "__module__", "") or ""
    return not module.startswith(("launcher.", "launch.", "launch_ros."))


def _function(entity: OpaqueFunction, where: str, *, is_first: bool) -> Unsupported:
    name = getattr(entity._function_called, "__name__", "function")
    what = f"OpaqueFunction {name}"
    if is_first:
        text = "it was called for the export; what it returned then is exported"
        return Unsupported(what=what, place=where, text=text, is_note=True)
    return Unsupported(what=what, place=where, text="it is not called when a process exits")


def _components(plan: Plan, places: Places) -> Iterator[Unsupported]:
    """A gap for each load, at the last action that may have asked for it."""
    loaders = [visit for visit in _visits(plan) if isinstance(visit.entity, _LOADERS)]
    for load, _ in plan.loads:
        fitting = [visit for visit in loaders if _loads_into(plan, visit, load.container)]
        where = places.of_entity(fitting[-1].entity) if fitting else THE_FILE
        text = f"the node is not loaded into {load.container}"
        yield Unsupported(what=f"ComposableNode {load.name or load.plugin}", place=where, text=text)


def _loads_into(plan: Plan, visit: Visit, container: str) -> bool:
    if isinstance(visit.entity, LoadComposableNodes):
        return True
    return any(_full_name(plan.processes[number]) == container for number in visit.processes)


def _full_name(process: PlannedProcess) -> str:
    ros = process.spec.ros
    if ros is None or ros.node_name is None:
        return ""
    return f"{(ros.namespace or '').rstrip('/')}/{ros.node_name}"


def _transitions(plan: Plan, places: Places) -> Iterator[Unsupported]:
    causes = [
        visit.entity
        for visit in _visits(plan)
        if isinstance(visit.entity, LifecycleTransition)
        or (isinstance(visit.entity, EmitEvent) and _changes_state(visit.entity))
    ]
    where = places.of_entity(causes[0]) if causes else THE_FILE
    for change, _ in plan.lifecycle:
        what = f"transition '{change.transition}' of {change.node}"
        yield Unsupported(what=what, place=where, text="nothing asks the lifecycle node for it")


def _left_out(plan: Plan, places: Places) -> Iterator[Unsupported]:
    for process in plan.processes:
        if is_exported(process):
            continue
        cause = _cause(process)
        after = "" if cause is None else f" the exit of {plan.processes[cause].spec.label}"
        text = f"it is not exported: it starts only after{after or ' a shutdown'}"
        where = places.of_text(process.spec.place)
        yield Unsupported(what=process.spec.label, place=where, text=text)
