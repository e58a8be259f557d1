"""Trees of plans: of a dry run, and of a running launch."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import (
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetLaunchConfiguration,
)
from launcher.language.actions.event_actions import Log, RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.actions.loops import ForEach, ForLoop
from launcher.language.actions.process import ExecuteLocal
from launcher.language.actions.timer import TimerAction, TimerScopeBegin, TimerScopeEnd
from launcher.language.description import LaunchDescription
from launcher.launch.plan.branches import (
    full_name,
    identity,
    joined,
    load_branch,
    restart_line,
    time_text,
    transition_branch,
)
from launcher.launch.plan.entities import (
    condition_text,
    handler_entities,
    handler_target,
    happening,
    headline,
    place,
    short_path,
)
from launcher.launch.plan.plan_certainty import is_own_function, process_names
from launcher.launch.plan.shell_command import ParameterFileWriter, command_line
from launcher.launch.plan.start_rules import start_lines
from launcher.launch.plan.tree import Branch

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

    from launcher.language.interpreter.trace import ConfigurationSetting, Visit
    from launcher.launch.plan.plan import Plan, PlannedProcess, Stamp
    from launcher.launch.plan.plan_places import Placed


# Not shown, only the group that contains them.
_SCOPE_PARTS = (
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
)
_OUTER_DEPTH = 3  # description, include of the command line, description of the file
_MAX_DEPTH = 30  # of visits; a launch file that includes itself goes deeper


def plan_tree(plan: Plan, files: ParameterFileWriter, placed: Sequence[Placed] = ()) -> Branch:
    """The tree of a dry run; generated parameter files are written by `files`.

    `placed` are the processes on their hosts, if there is a hosts file.
    """
    return _PlanTree(plan, files, placed).build()


def run_tree(plan: Plan) -> Branch:
    """The tree of a run, without groups: the visits of a run are not recorded."""
    arguments = [
        Branch(f"argument {name} = {value!r}", style="value")
        for name, value in plan.declared.items()
    ]
    processes = [_run_process(plan, process) for process in plan.processes]
    loads = [load_branch(load, time_text(stamp.time_s)) for load, stamp in plan.loads]
    changes = [
        transition_branch(change, time_text(stamp.time_s)) for change, stamp in plan.lifecycle
    ]
    children = [*arguments, *processes, *loads, *changes]
    return Branch(short_path(plan.path), style="scope", children=children)


class _PlanTree:
    def __init__(self, plan: Plan, files: ParameterFileWriter, placed: Sequence[Placed]) -> None:
        self._plan = plan
        self._files = files
        self._placed = dict(enumerate(placed))
        self._names = process_names(plan)
        self._loads = list(plan.loads)
        self._visit_of: dict[int, Visit] = {}  # by id of the entity, the last one
        self._owner: dict[int, Visit] = {}  # by id of an entity, the visit that yields it later
        self._later: dict[int, list[tuple[Visit, Visit]]] = {}  # by id of that visit
        self._loose: list[tuple[Visit, Visit]] = []  # (root, visit) without an owner

    def build(self) -> Branch:
        for root in self._plan.visits:
            for visit in root.walk():
                self._note_owner(visit)
        for root in self._plan.visits[1:]:
            self._find_place(root)
        children = [branch for root in self._plan.visits[:1] for branch in self._of_root(root)]
        children += [self._event(root, visit) for root, visit in self._loose]
        children += [self._load(load, stamp) for load, stamp in self._loads]
        children += [
            transition_branch(change, self._when(at)) for change, at in self._plan.lifecycle
        ]
        return Branch(short_path(self._plan.path), style="scope", children=children)

    def _when(self, stamp: Stamp, *, is_below: bool = False) -> str:
        """`at 5 s`, `when one-1 exits` (empty if it `is_below` that), `2 s after one-1 exits`."""
        origin = stamp.origin
        if origin is None:
            return time_text(stamp.time_s)
        delay_s = stamp.time_s - origin.time_s
        if origin.process is not None:
            subject = self._names[origin.process]
        else:
            subject = self._name(origin.event.action)
        text = f"{subject} {happening(origin.event)}"
        if delay_s:
            return f"{delay_s:g} s after {text}"
        return "" if is_below else f"when {text}"

    def _load(self, load: object, stamp: Stamp) -> Branch:
        return load_branch(load, self._when(stamp))

    # ---- owners of what happens later

    def _note_owner(self, visit: Visit) -> None:
        entity = visit.entity
        self._visit_of[id(entity)] = visit
        yielded: Iterable[Any] = ()
        if isinstance(entity, TimerAction):
            yielded = entity.actions
        elif isinstance(entity, RegisterEventHandler):
            yielded = handler_entities(entity.event_handler)
        for one in yielded:
            self._owner[id(one)] = visit

    def _find_place(self, root: Visit) -> None:
        visits = root.children if is_own_function(root.entity) else [root]
        for visit in visits:
            if isinstance(visit.entity, (TimerScopeBegin, TimerScopeEnd)):
                continue
            owner = self._owner.get(id(visit.entity)) or self._visit_of.get(
                id(getattr(root.event, "action", None))
            )
            if owner is None or owner is visit:
                self._loose.append((root, visit))
            else:
                self._later.setdefault(id(owner), []).append((root, visit))

    # ---- branches

    def _of_root(self, root: Visit) -> list[Branch]:
        """Branches of a root, without the include of the command line."""
        is_outer = root.depth <= _OUTER_DEPTH
        if is_outer and isinstance(root.entity, (IncludeLaunchDescription, LaunchDescription)):
            return [branch for child in root.children for branch in self._of_root(child)]
        names = {setting.name for setting in root.settings if setting.origin is None}
        if isinstance(root.entity, SetLaunchConfiguration) and names & self._plan.declared.keys():
            return []  # shown where it is declared
        return self._branches(root)

    def _branches(self, visit: Visit) -> list[Branch]:
        found = self._branches_of(visit)
        for branch in found:
            branch.place = branch.place or place(visit.entity._origin)
        return found

    def _branches_of(self, visit: Visit) -> list[Branch]:
        entity = visit.entity
        if visit.depth > _MAX_DEPTH:
            return [Branch("... and so on", style="skipped")]
        is_inner = isinstance(entity, ForEach) and _is_in(visit, ForLoop)
        if isinstance(entity, LaunchDescription) or is_inner:
            return [branch for child in visit.children for branch in self._branches(child)]
        if isinstance(entity, _SCOPE_PARTS) and _is_in(visit, GroupAction):
            return []
        if is_own_function(entity) and _is_in(visit, (ForEach, IncludeLaunchDescription)):
            return []
        if visit.skipped:
            return [
                Branch(
                    f"skipped: {headline(entity)}", style="skipped", aside=_condition_result(visit)
                )
            ]
        if isinstance(entity, ExecuteLocal) and visit.processes:
            return [self._process(visit, number) for number in visit.processes]
        if isinstance(entity, RegisterEventHandler):
            return [self._handler(visit)]
        return [self._other(visit)]

    def _other(self, visit: Visit) -> Branch:
        children = [branch for child in visit.children for branch in self._branches(child)]
        children += self._what_follows(visit)
        head, aside = _head(visit)
        style = "scope" if visit.children or children else "plain"
        if isinstance(visit.entity, TimerAction):
            style = "event"
        elif isinstance(visit.entity, (DeclareLaunchArgument, SetLaunchConfiguration)):
            style = "value"
        return Branch(
            head, style=style, aside=joined(aside, _condition_result(visit)), children=children
        )

    def _what_follows(self, visit: Visit) -> list[Branch]:
        branches: list[Branch] = []
        for root, later in self._later.get(id(visit), ()):
            if isinstance(visit.entity, TimerAction):
                branches += self._branches(later)
            else:
                branches.append(self._event(root, later, short=True))
        return branches

    def _event(self, root: Visit, visit: Visit, *, short: bool = False) -> Branch:
        action = getattr(root.event, "action", None)
        subject = "it" if short else self._name(action)
        head = f"when {subject} {happening(root.event)}" if action is not None else "later"
        aside = self._when(root.stamp, is_below=True)
        return Branch(head, style="event", aside=aside, children=self._branches(visit))

    def _handler(self, visit: Visit) -> Branch:
        handler = visit.entity.event_handler
        target, text = handler_target(handler)
        head = text if target is None else f"when {self._name(target)} {text}"
        followed = self._later.get(id(visit), ())
        children: list[Branch] = []
        for root, later in followed:
            if target is None and getattr(root.event, "action", None) is not None:
                children.append(self._event(root, later))
            else:
                children += self._branches(later)
        if not followed:
            head, children = f"{head} (not in this dry run)", _unvisited(handler_entities(handler))
        return Branch(head, style="event", aside=_condition_result(visit), children=children)

    def _name(self, action: Any) -> str:
        visit = self._visit_of.get(id(action))
        if visit is not None and visit.processes:
            return self._names[visit.processes[0]]
        if visit is None and getattr(action, "is_lifecycle_node", False):
            return f"component {action.node_name}"
        return headline(action)

    # ---- processes and components

    def _process(self, visit: Visit, number: int) -> Branch:
        process = self._plan.processes[number]
        host = f"on {self._placed[number].shown}" if number in self._placed else ""
        when = self._when(process.stamp, is_below=True)
        asides = [identity(process), host, when, _condition_result(visit)]
        children = [self._load(load, stamp) for load, stamp in self._loads_of(process)]
        return Branch(
            self._names[number],
            style="process",
            aside=joined(*asides, place(visit.entity._origin)),
            lines=self._process_lines(process, self._placed.get(number)),
            children=children + self._what_follows(visit),
            process=number,
        )

    def _process_lines(
        self, process: PlannedProcess, placed: Placed | None
    ) -> list[tuple[str, str]]:
        spec = process.spec
        if placed is not None and not placed.is_here:
            there = placed.lines(self._plan.environment, spec.env)
            after = [*restart_line(process), *start_lines(self._plan, process, self._names)]
            return [*there[:1], *after, *there[1:]]
        lines: list[tuple[str, str]] = []
        paths: dict[str, str] = {}
        for source in spec.ros.parameters if spec.ros else ():
            if source.generated is None or source.file is None:
                continue
            path, text = self._files.keep(spec.label, source.generated)
            paths[source.file] = path or "<generated>"
            lines += [("aside", f"{paths[source.file]}:")]
            lines += [("aside", f"  {line}") for line in text.splitlines()]
        command = command_line(spec, self._plan.environment, paths)
        starts = start_lines(self._plan, process, self._names)
        return [("command", f"$ {command}"), *restart_line(process), *starts, *lines]

    def _loads_of(self, process: PlannedProcess) -> list[Any]:
        ros = process.spec.ros
        if ros is None or ros.node_name is None:
            return []
        name = full_name(ros.namespace, ros.node_name)
        mine = [pair for pair in self._loads if f"/{pair[0].container.lstrip('/')}" == name]
        self._loads = [pair for pair in self._loads if pair not in mine]
        return mine


def _head(visit: Visit) -> tuple[str, str]:
    """(text, remark) of an entity that is not a process."""
    entity = visit.entity
    where = place(entity._origin)
    if isinstance(entity, (DeclareLaunchArgument, SetLaunchConfiguration)) and visit.settings:
        setting = visit.settings[-1]
        return f"{headline(entity)} = {setting.value!r}", _source(visit, setting)
    if isinstance(entity, Log) and visit.logs:
        return f"log: {visit.logs[-1]}", ""
    if visit.settings:
        setting = visit.settings[-1]
        return f"{headline(entity)}: {setting.name} = {setting.value!r}", where
    if isinstance(entity, GroupAction):
        scoped = any(isinstance(child.entity, PushLaunchConfigurations) for child in visit.children)
        return "group" if scoped else "group without a scope", where
    return headline(entity, visit.known), where


def _source(visit: Visit, setting: ConfigurationSetting) -> str:
    where = place(setting.origin)
    if setting.origin is None:
        return "command line"
    if isinstance(visit.entity, SetLaunchConfiguration):
        is_included = _is_in(visit, IncludeLaunchDescription)
        return f"launch_arguments at {where}" if is_included else f"set at {where}"
    is_own = setting.origin == visit.entity._origin
    return f"default at {where}" if is_own else f"set before at {where}"


def _condition_result(visit: Visit) -> str:
    """The condition with its value and the configurations that it has read."""
    condition = getattr(visit.entity, "condition", None)
    if condition is None or callable(condition):
        return ""
    values = ", ".join(f"{name} = {value!r}" for name, value in visit.read.items())
    answer = "no" if visit.skipped else "yes"
    return f"{condition_text(condition)}: {answer}{f' ({values})' if values else ''}"


def _unvisited(entities: Iterable[Any]) -> list[Branch]:
    return [
        Branch(headline(entity), style="skipped", place=place(entity._origin))
        for entity in entities
    ]


def _is_in(visit: Visit, kind: type | tuple[type, ...]) -> bool:
    return visit.parent is not None and isinstance(visit.parent.entity, kind)


def _run_process(plan: Plan, process: PlannedProcess) -> Branch:
    asides = [identity(process), time_text(process.stamp.time_s)]
    if process.stamp.cause is not None:
        asides.append(f"after the exit of {plan.processes[process.stamp.cause].spec.name}")
    # With the parameter files of the run, which exist until it ends.
    command = command_line(process.spec, plan.environment, {})
    return Branch(
        process.spec.name,
        style="process",
        aside=joined(*asides),
        lines=[("command", f"$ {command}"), *restart_line(process)],
    )
