"""Which nodes `--compose` puts into one process."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from launcher.base.model.events import StartProcess
from launcher.base.model.record import as_dict, replace
from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.spec import ProcessSpec, RestartMode
from launcher.base.model.supervision import rule_for
from launcher.base.text import count
from launcher.language.events.launch import IncludeLaunchDescription
from launcher.packages.python_program import PythonProgram, program_of
from launcher.run.compose.composed_core import ComposedCore, Composition
from launcher.run.parts import COMPOSED

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.launch.launch_core import LaunchCore
    from launcher.launch.plan.plan import Plan
    from launcher.run.core_driver import Core

_LABEL = "composed"
# What is one for a process, with its name in sentences.
_SHARED = {
    "env": "environment",
    "cwd": "working directory",
    "output": "output",
    "emulate_tty": "terminal",
    "restart": "restart policy",
    "stop": "stop policy",
    "limits": "limits",
}
# Of --ros-args, what is set once for a process.
_OF_PROCESS = (
    *("-e", "--enclave", "--log-config-file", "--log-file-name"),
    *("--disable-stdout-logs", "--disable-rosout-logs", "--disable-external-lib-logs"),
)
_Start = tuple[int, ProcessSpec]


def composed(core: LaunchCore, options: RunOptions) -> tuple[Core, frozenset[str]]:
    """The core of a run in which nodes that match are one process, and what is `absorbed`."""

    starts = [one for one in core.effects if isinstance(one, StartProcess)]
    specs = [(one.process_id, options.adapt(one.spec)) for one in starts]
    found = composition(specs, options, core.watches_output)
    run = ComposedCore(core, found, lambda spec: _late(spec, options, spec.name))
    return run, _absorbed(found)


def _absorbed(found: Composition) -> frozenset[str]:
    """The processes that are composed into another: all of a group but the first."""
    return frozenset(one.name for spec, _ in found.groups for one in spec.members[1:])


def composition_of(plan: Plan, options: RunOptions) -> tuple[Sequence[str], frozenset[str]]:
    """What a run of the plan would say about it, and the processes that are `absorbed`."""
    from launcher.launch.plan.plan_certainty import process_names

    later = {
        number
        for root in plan.visits
        if root.stamp.time_s or not isinstance(root.event, (IncludeLaunchDescription, type(None)))
        for one in root.walk()
        for number in one.processes
    }
    at_once = [
        (number, one.spec) for number, one in enumerate(plan.processes) if number not in later
    ]
    found = composition(at_once, options)
    names = process_names(plan)
    late = [_late(plan.processes[number].spec, options, names[number]) for number in sorted(later)]
    return [*found.remarks, *filter(None, late)], _absorbed(found)


def _late(spec: ProcessSpec, options: RunOptions, name: str) -> str | None:
    if not any(matches(pattern, spec) for pattern in options.compose):
        return None
    return f"{name} is not composed: it is not started at the beginning of the run"


def composition(
    starts: Sequence[_Start],
    options: RunOptions,
    watches_output: Callable[[int], bool] = lambda number: False,
) -> Composition:
    """Of the processes that are started at once, as (id, spec with all options applied)."""
    search = _ComposableSearch(options, watches_output, [spec.name for _, spec in starts])
    left = list(starts)
    for pattern in options.compose:
        search.compose(pattern, [one for one in left if matches(pattern, one[1])])
        left = [one for one in left if not matches(pattern, one[1])]
    return Composition(groups=tuple(search.groups), remarks=tuple(search.remarks))


class _ComposableSearch:
    def __init__(
        self, options: RunOptions, watches_output: Callable[[int], bool], names: Sequence[str]
    ) -> None:
        self._options = options
        self._watches_output = watches_output
        self._names = set(names)
        self._reasons: dict[tuple[str, str], str] = {}
        self.groups: list[tuple[ProcessSpec, tuple[int, ...]]] = []
        self.remarks: list[str] = []

    def compose(self, pattern: str, starts: Sequence[_Start]) -> None:
        """Those with the same settings become a process, unless there is only one of them."""
        alike: dict[tuple[object, ...], list[_Start]] = {}
        for number, spec in starts:
            reason = self._reason(number, spec)
            if reason:
                self._refuse(spec, reason)
            else:
                alike.setdefault(_settings(spec), []).append((number, spec))
        largest = max(alike.values(), key=len, default=[])
        for group in alike.values():
            if len(group) > 1:
                self._add(group)
            elif group is largest:
                self._refuse(group[0][1], f"there is no other that '{pattern}' could put with it")
            else:
                self._refuse(group[0][1], _difference(group[0][1], largest[0][1]))

    def _refuse(self, spec: ProcessSpec, reason: str) -> None:
        self.remarks.append(f"{spec.name} is not composed: {reason}")

    def _add(self, group: Sequence[_Start]) -> None:
        number = len(self.groups) + 1
        while (name := f"{_LABEL}-{number}") in self._names:
            number += 1
        members = tuple(self._member(spec) for _, spec in group)
        words = [word for one in members for word in _words(one)]
        first = members[0]
        spec = replace(
            first,
            name=name,
            label=_LABEL,
            argv=(sys.executable, "-m", COMPOSED, *words),
            ros=None,
            members=members,
            is_essential=False,
        )
        self._names.add(name)
        self.groups.append((spec, tuple(number for number, _ in group)))
        names = ", ".join(one.name for one in members)
        self.remarks.append(f"{name} is one process for {count(len(members), 'node')}: {names}")

    def _member(self, spec: ProcessSpec) -> ProcessSpec:
        ends_all = spec.restart.mode is RestartMode.ALWAYS or self._options.is_required(spec)
        return replace(spec, is_essential=ends_all)

    # ---- reasons

    def _reason(self, number: int, spec: ProcessSpec) -> str:
        """Why it has to be a separate process; empty if it does not."""
        if spec.ros is None:
            return "it is not started as a ROS node"
        if spec.shell:
            return "it is started by a shell"
        if not rule_for(self._options.start_rules, spec).is_empty:
            return "the supervision file has rules for it"
        if self._watches_output(number):
            return "an event handler reads its output"
        program = program_of(spec.argv, spec.env, spec.cwd)
        if isinstance(program, str):
            return program
        found = next((word for word in program.words if word in _OF_PROCESS), None)
        if found is not None:
            return f"'{found}' is a setting of a process"
        return self._reason_of(program, spec)

    def _reason_of(self, program: PythonProgram, spec: ProcessSpec) -> str:
        """Of its source; looked at once for all that run it."""
        key = program.script, program.module
        if key not in self._reasons:
            from launcher.packages.imports import imports_of

            found = imports_of(program.script, program.module)
            names = {name.partition(".")[0] for name in (*found.installed, *found.deferred)}
            forks = "it imports multiprocessing, which forks the process it is in"
            self._reasons[key] = forks if "multiprocessing" in names else ""
        return self._reasons[key]


def _settings(spec: ProcessSpec) -> tuple[object, ...]:
    fields = as_dict(spec)
    env = tuple(sorted(spec.env.items()))
    return (env, *(fields[name] for name in _SHARED if name != "env"))


def _difference(spec: ProcessSpec, other: ProcessSpec) -> str:
    """`its environment (HOME) is not that of robot_1-1`."""
    mine, theirs = as_dict(spec), as_dict(other)
    name = next(name for name in _SHARED if mine[name] != theirs[name])
    text = _SHARED[name]
    if name == "env":
        names = sorted(n for n in {*spec.env, *other.env} if spec.env.get(n) != other.env.get(n))
        text += f" ({', '.join(names)})"
    return f"its {text} is not that of {other.name}"


def _words(one: ProcessSpec) -> list[str]:
    """As `launcher.ros.composed.member_group` reads them."""
    head = ["--essential"] if one.is_essential else []
    return [*head, one.name, str(len(one.argv)), *one.argv]
