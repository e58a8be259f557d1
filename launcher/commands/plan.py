"""`plan TARGET [name:=value ...]`: what a launch file would do. Nothing is started."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from launcher.commands import words as command_line
from launcher.commands.quiet import stdout_to_stderr
from launcher.errors import ExitCode

if TYPE_CHECKING:
    from launcher.planner import Plan

USAGE = """usage: python -m launcher plan TARGET [name:=value ...] [--json] [--lenient] [--debug]
       python -m launcher plan PACKAGE FILE [name:=value ...]

Starts nothing and shows what would be started when, with which command line, and why.

options:
  --json     the plan as one JSON object; exit code 0 also where the launch file fails
  --lenient  accept argument names that nothing declares or reads, as ROS 2 does
  --debug    show the traceback of an error"""

JSON = ("--json",)
LENIENT = ("--lenient",)


def main(words: Sequence[str]) -> int:
    """Plan the launch file that `words` name; the exit code."""
    if command_line.wants_help(words):
        print(USAGE)
        return ExitCode.OK
    request = command_line.read(
        words, verb="plan", usage=USAGE.splitlines()[0], flags=(JSON, LENIENT)
    )
    from launcher.planner import make_plan

    with stdout_to_stderr():
        plan = make_plan(request.path, request.arguments)
    if "--json" in request.options:
        return _print_document(plan)
    return _print_tree(plan)


def _print_tree(plan: Plan) -> int:
    from launcher.render.command_line import ParameterFiles
    from launcher.render.plan_tree import plan_tree
    from launcher.render.tree import draw

    colour = sys.stdout.isatty()
    print(draw(plan_tree(plan, ParameterFiles()), colour=colour))
    if plan.error is None:
        return ExitCode.OK
    print(plan.error.fault.render(), file=sys.stderr)
    return ExitCode.USAGE


def _print_document(plan: Plan) -> int:
    import json

    from launcher.render.plan_json import document

    json.dump(document(plan), sys.stdout, indent=1)
    print()
    return ExitCode.OK
