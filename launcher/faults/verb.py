"""`faults`: what is wrong in a watched run, from another shell, and in all runs before."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.option import DEBUG, option
from launcher.base.verb_table import VERBS
from launcher.control import verbs
from launcher.control.active_runs import find_run
from launcher.control.client import Connection
from launcher.control.fault_texts import FaultLines, is_reported
from launcher.posix.json_output import print_document, print_line

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.run_verb import Call

_VERB = verbs.known("faults")  # the same of the control socket
COMMAND = Command(
    "faults",
    VERBS["faults"],
    synopsis="[-f] [--check] [--mute FAULT] [--run ID] [--json] | --all-runs [TARGET]",
    about="""\
List the faults of a run that was started with --watchful or --expect, each with its cause; one
that follows from another is indented below it. With -f, print a line for each change until Ctrl-C
or the end of the run. With --all-runs, list those of all runs in the log folder: since when, how
often, and in which versions of the launch file.""",
    arguments=(option("[TARGET]", "with --all-runs: a launch file, or the beginning of its name"),),
    options=(
        *_VERB.options,
        option(
            "--check",
            "exit with code 1 if a fault is active that is not muted, and with 2 if that is not "
            "known: no run, or one that is not watched",
        ),
        option("--all-runs", "list the faults of all runs in the log folder"),
        option("--json", "print one JSON object; with -f, one per line"),
        option("--run ID", "id, pid or target of the run, or the beginning of one of these"),
        DEBUG,
    ),
    exclusive=(("follow", "check", "acknowledge", "mute", "unmute"),),
)


def main(words: Sequence[str]) -> int:
    """Show the faults, or change one; the exit code."""
    options = COMMAND.parse(words)
    if options.all_runs:
        return _show_history(options)
    if options.target is not None:
        hint = "a run is chosen by --run"
        raise UsageError(f"'{options.target}': a target belongs to --all-runs", hint=hint)
    call = verbs.call_of(_VERB, options)
    try:
        return _ask(call, options)
    except LauncherError as error:
        if options.check:
            error.exit_code = ExitCode.USAGE  # 1 is for faults
        raise


def _ask(call: Call, options: Parsed) -> int:
    run = find_run(options.run, _warn, read_only=verbs.only_reads("faults", call.options))
    with run.connect() as connection:
        if options.follow:
            return _follow(connection, call, as_json=options.json)
        return _show(connection, call, as_json=options.json, checks=options.check)


def _show_history(options: Parsed) -> int:
    from launcher.faults.history import listing

    belongs = {"all_runs", "json", "debug", "workspace"}
    for one, words, _ in options.given:
        if one is not None and one.name not in belongs:
            raise UsageError(f"--all-runs and {words[0]} exclude each other")
    return listing.show(os.environ, options.target, as_json=options.json)


def _follow(connection: Connection, call: Call, *, as_json: bool) -> int:
    lines = FaultLines()
    try:
        for item in connection.follow("faults", (), **call.options):
            if as_json:
                print_line(item)
            elif line := lines.of(item):
                print(line, flush=True)
    except KeyboardInterrupt:
        pass  # its normal end
    return ExitCode.OK


def _show(connection: Connection, call: Call, *, as_json: bool, checks: bool) -> int:
    reply = connection.ask("faults", (), **call.options)
    result = reply.result
    if as_json:
        print_document(result)
    elif set(_VERB.changing) & call.options.keys():
        print("\n".join(reply.text))
    else:
        _print_table(result)
    if not checks:
        return ExitCode.OK
    if any(map(is_reported, result["faults"])) and result["watching"]:
        return ExitCode.PROCESS_FAILED
    return ExitCode.OK if result["watching"] else ExitCode.USAGE


def _print_table(result: dict[str, Any]) -> None:
    from launcher.control.console.fault_table import fault_table
    from launcher.control.console.process_tables import render
    from launcher.control.verb import table_width
    from launcher.output.stdout import wants_colour

    columns = table_width()
    print(render(fault_table(result, columns), columns, colour=wants_colour(1, os.environ)))


def _warn(text: str) -> None:
    print(f"note: {text}", file=sys.stderr)
