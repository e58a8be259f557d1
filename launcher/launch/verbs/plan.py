"""`plan TARGET [name:=value ...]`: show what a launch file would start. Nothing is started."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, LaunchFileError, UsageError
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions
from launcher.base.option import JSON, option
from launcher.base.verb_table import VERBS
from launcher.launch.launch_options import (
    LOG_LEVEL,
    NO_SUPERVISE,
    PREFIX,
    SUPERVISE,
    given_options,
    refuse_conflicts,
    with_settings_beside,
)
from launcher.launch.needed_release import TARGETS
from launcher.launch.needed_release import warnings as needed_releases
from launcher.launch.target import (
    ABOUT_TARGET,
    DEBUG,
    EVALUATION_TIMEOUT,
    LENIENT,
    SYNOPSIS,
    TARGET,
    LaunchRequest,
    parse_words,
)
from launcher.launch.time_limit import limited
from launcher.posix.stdio import print_text, stdout_to_stderr
from launcher.run.part_options import COMPOSE, DISCOVERY, SKIP_HOST
from launcher.run.parts import planned_hosts

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.control.active_runs import ListedRun
    from launcher.launch.plan.plan import Plan
    from launcher.launch.plan.plan_places import PlanPlaces

_HOSTS = option("--hosts FILE", "show where processes run as this file says, and what runs there")
_TARGET = option(
    "--target NAME",
    "the distribution of ROS 2 that is to run the launch file, instead of the installed one: warn "
    "of what is newer",
    choices=TARGETS,
)
# A running launch has its own.
_OF_A_NEW_RUN = (
    *(_HOSTS, SKIP_HOST, DISCOVERY, PREFIX, LOG_LEVEL, COMPOSE, _TARGET),
    *(SUPERVISE, NO_SUPERVISE),
)
COMMAND = Command(
    "plan",
    VERBS["plan"],
    arguments=(TARGET,),
    synopsis=f"[{SYNOPSIS.removesuffix(' [options]')}] [options]",
    about=f"""\
Show which processes would be started when, with which command line, and why. Functions and
commands of the launch file are executed, as when it is launched. Without TARGET: what the running
launch has done so far.

{ABOUT_TARGET}""",
    options=(
        replace(JSON, help=f"{JSON.help}; exit code 0 also if the launch file fails"),
        LENIENT,
        EVALUATION_TIMEOUT,
        _HOSTS,
        SKIP_HOST,
        DISCOVERY,
        PREFIX,
        LOG_LEVEL,
        COMPOSE,
        _TARGET,
        option(
            "--diff",
            "what reloading the running launch (of TARGET) would start, stop and restart, with its "
            "launch file as it is now",
        ),
        SUPERVISE,
        NO_SUPERVISE,
        option("--supervise-schema", "print the JSON Schema of supervision files"),
        option("--run ID", "without TARGET: the id, pid or target of the running launch"),
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    """Plan the launch file that `words` name; the exit code."""
    parsed = parse_words(COMMAND, words)
    if parsed.supervise_schema:
        return _show_schema()
    if parsed.diff:
        return _show_diff(parsed)
    if not parsed.words:
        return _show_running(parsed)
    if parsed.run is not None:
        raise UsageError("--run and TARGET exclude each other")
    options = given_options(parsed)
    refuse_conflicts(options, parsed.hosts)
    request = LaunchRequest.of(parsed)
    return show(
        request,
        as_json=parsed.json,
        target=parsed.target,
        options=replace(
            with_settings_beside(options, request.path),
            hosts=parsed.hosts,
            discovery=parsed.discovery,
            skip_hosts=tuple(parsed.skip_hosts),
        ),
    )


def _show_schema() -> int:
    from launcher.base import strict_json
    from launcher.launch.supervise.supervise_fields import json_schema

    print_text(strict_json.dumps(json_schema(), indent=2, ensure_ascii=False))
    return ExitCode.OK


def show(
    request: LaunchRequest,
    *,
    as_json: bool = False,
    target: str | None = None,
    options: RunOptions | None = None,
) -> int:
    """Print the plan of the request; LauncherError below it for what is wrong.

    `options` change processes as in a run, and say on which hosts they run; `target` is the
    distribution of ROS 2.
    """
    places = None
    if options is not None and (options.hosts or options.discovery or options.skip_hosts):
        places = planned_hosts(options)
    has_rules = options is not None and bool(options.start_rules)
    plan = evaluate(request, with_scopes=places is not None or has_rules, target=target)
    remarks = needed_releases(plan.uses, plan.distribution, is_target=target is not None)
    remarks += [] if options is None else _apply(options, plan)
    errors = mistakes_of(plan, request)
    if plan.start_rules:
        from launcher.launch.supervise.circles import circle_among

        circle = circle_among(plan.start_rules, [process.spec for process in plan.processes])
        errors += [] if circle is None else [circle]
    if places is not None:
        places.place(plan)
        errors += places.errors
    if as_json:
        _show_document(plan, errors, places, remarks)
        return ExitCode.OK if places is None or not places.errors else ExitCode.USAGE
    _show_tree(plan, places, remarks)
    if not errors:
        return ExitCode.OK
    from launcher.launch.mistakes import together

    raise together(errors, plan.error.fault if plan.error else None)


def _apply(options: RunOptions, plan: Plan) -> list[str]:
    """Change the processes of the plan as a run does; warnings about the options."""
    plan.start_rules = options.start_rules
    if not (options.log_levels or options.prefix or options.file_names or options.compose):
        return []
    from launcher.run.option_warnings import unmatched, without_node

    plan.processes = [replace(one, spec=options.adapt(one.spec)) for one in plan.processes]
    specs = [process.spec for process in plan.processes]
    known = [*specs, *plan.switched_off]
    missing = [f"{text}{meant}" for text, meant in unmatched(options, known)]
    remarks = [f"warning: {text}" for text in (*missing, *without_node(options, specs))]
    return [*remarks, *_composed(options, plan)]


def _composed(options: RunOptions, plan: Plan) -> list[str]:
    """What `--compose` makes of the processes of the plan."""
    if not options.compose:
        return []
    from launcher.launch.composing import composition_of

    remarks, plan.absorbed = composition_of(plan, options)
    return [f"note: {text}" for text in remarks]


def _show_running(parsed: Parsed) -> int:
    """What the running launch has done so far; LauncherError if there is no such run."""
    from launcher.control.active_runs import NoActiveRunError, files_of_last_run, find_run

    try:
        run = find_run(parsed.run, read_only=True)
    except NoActiveRunError:
        hint = f"usage: {parsed.command.usage}"
        for file in files_of_last_run("plan"):
            hint += f"\nthe plan of the last run: {file}"
        raise UsageError("the launch file is missing, and no run is active", hint=hint) from None
    return _print_answer(run, parsed, "plan")


def _show_diff(parsed: Parsed) -> int:
    """Ask the run, which has the arguments and the environment; LauncherError."""
    from launcher.control.active_runs import find_run

    for one, (flag, *_), _ in parsed.given:
        if one in _OF_A_NEW_RUN:
            hint = "the launch file is compared with the options that the run has got"
            raise UsageError(f"--diff takes no {flag.partition('=')[0]}", hint=hint)
    which = parsed.run
    if parsed.words and which is not None:
        raise UsageError("--run and TARGET exclude each other")
    if parsed.words:
        request = LaunchRequest.of(parsed)
        if request.arguments:
            words = " ".join(f"{name}:={value}" for name, value in request.arguments)
            hint = "the launch file is compared with the arguments that the run has got"
            raise UsageError(f"--diff takes no arguments: {words}", hint=hint)
        which = request.path
    return _print_answer(find_run(which, read_only=True), parsed, "reload", dry_run=True)


def _print_answer(run: ListedRun, parsed: Parsed, verb: str, **options: Any) -> int:
    with run.connect() as connection:
        reply = connection.ask(verb, **options)
    if parsed.json:
        from launcher.posix.json_output import print_document

        print_document(reply.result)
    else:
        print_text("\n".join(reply.text))
    return ExitCode.OK


def evaluate(
    request: LaunchRequest, *, with_scopes: bool = False, target: str | None = None
) -> Plan:
    """The plan; what the launch file prints goes to standard error."""
    from launcher.launch.plan.plan import Plan, PlanError
    from launcher.launch.plan.planner import make_plan

    try:
        with stdout_to_stderr(), limited(request.time_limit, request.path):
            return make_plan(
                request.path,
                request.arguments,
                with_scopes=with_scopes,
                debug=request.debug,
                target=target,
            )
    except LaunchFileError as fault:
        # It was interrupted; how far it got is unknown.
        plan = Plan(request.path)
        plan.arguments_error = fault.message
        plan.error = PlanError(
            kind="TimeoutError", message=fault.message, stage="run", phase="run", fault=fault
        )
        return plan


def mistakes_of(plan: Plan, request: LaunchRequest) -> list[LauncherError]:
    """Everything that is wrong with the launch file and its arguments."""
    unknown = [name for name, _ in request.arguments if name not in plan.known_names]
    if plan.error is None and not unknown:
        return []
    from launcher.launch import mistakes
    from launcher.launch.known_names import known_names

    errors: list[LauncherError] = []
    if unknown and plan.description is not None and not request.lenient:
        with stdout_to_stderr():
            known = known_names(plan)
        errors, warnings = mistakes.unknown_names(request.arguments, known, plan.declared)
        for warning in warnings:
            print(f"warning: {warning}", file=sys.stderr)
    if plan.error is not None:
        if plan.error.phase == "exit" and not plan.error.fault.hint:
            plan.error.fault.hint = "this happens later, when a process has ended"
        errors += mistakes.of_launch_file(
            plan.error.fault, plan.description, plan.context, request.arguments, os.environ
        )
    return errors


def _show_document(
    plan: Plan,
    errors: Sequence[LauncherError],
    places: PlanPlaces | None = None,
    remarks: Sequence[str] = (),
) -> None:
    """The document alone on standard output; for people, the rest on standard error."""
    from launcher.launch.plan.plan_json import document
    from launcher.posix.json_output import print_document

    placed = () if places is None else places.placed
    found = document(plan, placed)
    if places is not None:
        found["discovery"] = places.discovery_document()
    print_document(found)
    for line in [*_warnings(plan, places), *remarks, *(error.render() for error in errors)]:
        print(line, file=sys.stderr)


def _show_tree(
    plan: Plan,
    places: PlanPlaces | None = None,
    remarks: Sequence[str] = (),
) -> None:
    from launcher.launch.plan.plan_tree import plan_tree
    from launcher.launch.plan.shell_command import ParameterFileWriter
    from launcher.launch.plan.tree import draw
    from launcher.output.stdout import wants_colour

    placed = () if places is None else places.placed
    tree = draw(plan_tree(plan, ParameterFileWriter(), placed), colour=wants_colour(1, os.environ))
    lines = [tree, *_warnings(plan, places), *remarks]
    if places is not None and (line := places.discovery_line()):
        lines.append(line)
    print_text("\n".join(lines))


def _warnings(plan: Plan, places: PlanPlaces | None) -> list[str]:
    lines = [surprise.render() for surprise in plan.warnings]
    lines += () if places is None else places.warnings
    lines += [f"warning: {message}" for message in _programs(plan, places)]
    lines += [f"warning: {message}" for message in _crowds(plan, places)]
    return [*lines, f"warning: {plan.empty_run}"] if plan.empty_run else lines


def _programs(plan: Plan, places: PlanPlaces | None) -> list[str]:
    """About programs of this machine that cannot be executed now."""
    from launcher.launch.program_warnings import program_warnings

    specs = [process.spec for process in plan.processes]
    if places is None:
        return program_warnings(specs)
    placed = zip(specs, places.placed, strict=True)
    return program_warnings(spec for spec, one in placed if one.is_here)


def _crowds(plan: Plan, places: PlanPlaces | None) -> list[str]:
    """About nodes on this machine."""
    from launcher.launch.participant_limits import crowds, of_run

    if places is None:
        return crowds(of_run(plan))
    environment = places.crowd_environment()
    return [] if environment is None else crowds(of_run(plan), environment)
