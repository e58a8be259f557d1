"""The plan document of what a run has done so far, in the form of `plan --json`.

Nothing is evaluated a second time: the document is made of the effects that the interpreter
requested during the run. It differs from that of `plan` as follows:

* times are real, in seconds since the start; phase `exit` marks effects of the end of a process,
  at whatever time, and `cause` is that process;
* `arguments` are those whose declarations were executed; `plan` also lists those of includes that
  a condition excludes;
* `shutdowns` has the request that ended the run;
* a very long run is recorded up to a limit.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence

from launcher.base.model import events as model
from launcher.base.model.spec import ProcessSpec
from launcher.launch.plan.plan import Plan, PlannedProcess, Stamp
from launcher.launch.plan.plan_json import document
from launcher.launch.plan.planner import USER_LOGGER, plan_error, with_temporary_files

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.interpreter import Interpreter


# What an event led to: time on the monotonic clock, process_id if the event was the end of a
# process, effects. The first step is the start.
RunStep = tuple[float, "int | None", Sequence[model.Effect]]
Adapt = Callable[[ProcessSpec], ProcessSpec]  # by options of the run


def run_document(
    interpreter: Interpreter, path: str, steps: Sequence[RunStep], adapt: Adapt
) -> dict[str, Any]:
    """The document of the steps so far, ready for JSON."""
    return document(run_plan(interpreter, path, steps, adapt))


def run_text(
    interpreter: Interpreter, path: str, steps: Sequence[RunStep], adapt: Adapt
) -> list[str]:
    """The same as a tree, line by line."""
    from launcher.launch.plan.plan_tree import run_tree  # only if somebody asks for it
    from launcher.launch.plan.tree import draw

    tree = draw(run_tree(run_plan(interpreter, path, steps, adapt)), colour=False)
    return tree.split("\n")


def run_plan(interpreter: Interpreter, path: str, steps: Sequence[RunStep], adapt: Adapt) -> Plan:
    plan = Plan(path)
    plan.environment = interpreter.environment
    plan.arguments = list(interpreter.host.declared_arguments.values())
    plan.declared = dict(interpreter.host.declared_values)
    _PlanBuilder(plan, interpreter, adapt).add(steps)
    if interpreter.failure is not None:
        plan.error = plan_error(interpreter.failure, "run", "run")
    return plan


class _PlanBuilder:
    def __init__(self, plan: Plan, interpreter: Interpreter, adapt: Adapt) -> None:
        self._plan = plan
        self._adapt = adapt
        self._interpreter = interpreter
        self._indices: dict[int, int] = {}  # process_id -> index in the plan
        self._is_over = False

    def add(self, steps: Sequence[RunStep]) -> None:
        for when_s, ended, effects in steps:
            cause = None if ended is None else self._indices.get(ended)
            for effect in effects:
                phase = "run" if cause is None else "exit"
                phase = "shutdown" if self._is_over else phase
                time_s = round(when_s - steps[0][0], 3)
                since_s = None if cause is None else 0.0
                stamp = Stamp(time_s=time_s, phase=phase, cause=cause, since_cause_s=since_s)
                self._add_effect(effect, stamp)

    def _add_effect(self, effect: model.Effect, stamp: Stamp) -> None:
        plan = self._plan
        match effect:
            case model.StartProcess(process_id=process_id):
                self._indices[process_id] = len(plan.processes)
                plan.processes.append(self._planned(effect, stamp))
            case model.LogMessage(logger=logger, text=text, sink=sink):
                if logger == USER_LOGGER and sink != "log":
                    plan.logs.append((text, stamp))
            case model.LoadComponent(request=load):
                plan.loads.append((load, stamp))
            case model.ChangeState(request=change):
                plan.lifecycle.append((change, stamp))
            case model.RequestShutdown(reason=reason):
                plan.shutdowns.append((reason, stamp))
                self._is_over = True

    def _planned(self, effect: model.StartProcess, stamp: Stamp) -> PlannedProcess:
        action = self._interpreter.host.processes[effect.process_id].action
        respawn, delay_s, retries = action._respawn_settings()
        spec = effect.spec
        with contextlib.suppress(FileNotFoundError):  # a temporary file that has been removed
            spec = with_temporary_files(spec)
        return PlannedProcess(
            spec=self._adapt(spec),
            respawn=respawn,
            respawn_delay=delay_s,
            respawn_max_retries=retries,
            stamp=stamp,
        )
