"""`plan TARGET [name:=value ...]`: what a launch file would do. Nothing is started."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from launcher.commands.launch import target as command_line
from launcher.commands.launch.redirection import say, stdout_to_stderr
from launcher.commands.launch.time_limit import TimeLimit, limited
from launcher.errors import ExitCode, LauncherError, LaunchFileError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.planner import Plan

USAGE = """usage: python -m launcher plan TARGET [name:=value ...] [--json] [--lenient] [--debug]
       python -m launcher plan PACKAGE FILE [name:=value ...]

Starts nothing and shows what would be started when, with which command line, and why. Functions
and commands of the launch file do run, as they do when it is launched.

options:
  --json                  the plan as one JSON object; exit code 0 also where the file fails
  --lenient               accept argument names that nothing declares or reads, as ROS 2 does
  --evaluation-timeout S  how long the launch file may take; 0 for any time (default: 60 s,
                          and 20 s of computing)
  --debug                 show the traceback of an error"""

JSON = ("--json",)
LENIENT = ("--lenient",)
PATIENCE = ("--evaluation-timeout",)


def main(words: Sequence[str]) -> int:
    """Plan the launch file that `words` name; the exit code."""
    if command_line.wants_help(words):
        say(USAGE)
        return ExitCode.OK
    request = command_line.read(
        words,
        verb="plan",
        usage=USAGE.splitlines()[0],
        flags=(JSON, LENIENT),
        valued=(PATIENCE,),
    )
    return show(request, TimeLimit.given(request.options.get(PATIENCE[0])))


def show(request: command_line.LaunchRequest, patience: TimeLimit) -> int:
    """Print the plan of the request; LauncherError below it for what is wrong."""
    plan = evaluate(request, patience)
    errors = mistakes_of(plan, request)
    if JSON[0] in request.options:
        _show_document(plan, errors)
        return ExitCode.OK
    _show_tree(plan)
    if not errors:
        return ExitCode.OK
    from launcher.commands.launch.mistakes import together

    raise together(errors) from (plan.error.fault if plan.error else None)


def evaluate(request: command_line.LaunchRequest, patience: TimeLimit) -> Plan:
    """The plan; what the launch file prints goes to standard error."""
    from launcher.planner import Plan, PlanError, make_plan

    try:
        with stdout_to_stderr(), limited(patience, request.path):
            return make_plan(request.path, request.arguments)
    except LaunchFileError as fault:
        # It had to be interrupted; how far it came is not known.
        plan = Plan(request.path)
        plan.arguments_error = fault.message
        plan.error = PlanError(
            kind="TimeoutError", message=fault.message, stage="run", phase="run", fault=fault
        )
        return plan


def mistakes_of(plan: Plan, request: command_line.LaunchRequest) -> list[LauncherError]:
    """Everything that is wrong with the launch file and its arguments."""
    unknown = [name for name, _ in request.arguments if name not in plan.known_names]
    if plan.error is None and not unknown:
        return []
    from launcher.commands.launch import mistakes
    from launcher.commands.launch.known_names import known_names

    errors: list[LauncherError] = []
    if unknown and plan.description is not None and LENIENT[0] not in request.options:
        with stdout_to_stderr():
            known = known_names(plan)
        errors += mistakes.unknown_names(request.arguments, known, plan.declared)
    if plan.error is not None:
        if plan.error.phase == "exit" and not plan.error.fault.hint:
            plan.error.fault.hint = "this happens later, when a process has ended"
        errors += mistakes.of_launch_file(
            plan.error.fault, plan.description, plan.context, request.arguments, os.environ
        )
    return errors


def _show_document(plan: Plan, errors: Sequence[LauncherError]) -> None:
    """The document alone on standard output; for people, the rest on standard error."""
    import json

    from launcher.render.plan_json import document

    say(json.dumps(document(plan), indent=1))
    for line in [*_warnings(plan), *(error.render() for error in errors)]:
        print(line, file=sys.stderr)


def _show_tree(plan: Plan) -> None:
    from launcher.engine.screen import wants_colour
    from launcher.render.command_line import ParameterFiles
    from launcher.render.plan_tree import plan_tree
    from launcher.render.tree import draw

    tree = draw(plan_tree(plan, ParameterFiles()), colour=wants_colour(1, os.environ))
    say("\n".join([tree, *_warnings(plan)]))


def _warnings(plan: Plan) -> list[str]:
    return [
        f"warning: {f'{surprise.origin}: ' if surprise.origin else ''}{surprise.text}"
        for surprise in plan.warnings
    ]
