"""`ps`, `top`, `kill`, `stop`, `logs` and so on: control a running launch from another shell."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.command_help import sentence
from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, JSON, JSON_LINES, option
from launcher.base.program import program
from launcher.base.run_verb import Call, Verb
from launcher.control import verbs
from launcher.control.active_runs import (
    AnyRun,
    ListedRun,
    NoActiveRunError,
    all_runs,
    files_of_last_run,
    find_run,
)
from launcher.control.answer_lines import event_line, log_line, without_colour
from launcher.control.client import Connection
from launcher.language.frontends.locate import launch_names
from launcher.posix.json_output import print_document, print_line

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

WIDE = 1000  # columns of a table that goes into a pipe
NAMES = """\
NAME is a process (`robot_2-4`), its label (`robot_2`), its node (`/fleet/robot_2`), a pattern of
these (`robot_*`), or a namespace, which means everything below it (`/fleet`)."""


def _run_id(text: str) -> str:
    if not text:
        raise ValueError("the id of a run is missing")
    return text


_RUN = option("--run ID", "id, pid or target of the run, or the beginning of one of these", _run_id)
RUNS = Command("runs", "list the running launches", options=(JSON, DEBUG), synopsis="[--json]")


def command_of(verb: Verb) -> Command:
    about = sentence(verb.help) + (f"\n\n{NAMES}" if verb.names != "none" else "")
    as_json = JSON_LINES if verb.streams else JSON
    return verb.command(in_shell=True, about=about, common=(_RUN, DEBUG), as_json=as_json)


def main(words: Sequence[str]) -> int:
    """Run the verb `words[0]`; the exit code."""
    name, *rest = words
    verb = verbs.find(name)
    if verb is None:
        return _runs(RUNS.parse(rest))
    options = verbs.parsed_by(command_of(verb), rest)
    call = verbs.call_of(verb, options)
    with _find_run(options.run, call).connect() as connection:
        try:
            return _PRINT.get(name, _print_reply)(connection, call, options)
        except KeyboardInterrupt:
            if verb.streams:
                return ExitCode.OK  # Ctrl-C is its normal end
            raise


def _find_run(which: str | None, call: Call) -> ListedRun:
    """As `find_run`; where no run is active, the error names the files of the last one."""
    name = call.verb.name
    try:
        return find_run(which, _warn, read_only=verbs.only_reads(name, call.options))
    except NoActiveRunError as error:
        files = files_of_last_run(name, call.names)
        if name in ("start", "restart") and call.names[0] in launch_names(os.environ):
            error.hint = f"did you mean `{program()} {call.names[0]}`?"
        elif files:
            error.hint = "\n".join(["files of the last run:", *(f"  {file}" for file in files)])
        raise


def _warn(text: str) -> None:
    print(f"note: {text}", file=sys.stderr)


def _runs(options: Parsed) -> int:
    found = [_as_document(run) for run in all_runs(_warn)]
    if options.json:
        print_document({"runs": found})
    elif found:
        _print_table(_run_table(found))
    else:
        print("no active run")
    return ExitCode.OK


def _as_document(run: AnyRun) -> dict[str, Any]:
    known = {"id": run.run_id, "pid": run.pid, "socket": str(run.path)}
    return {**known, **{key: getattr(run, key, None) for key in _FIELDS}}


# None for a run that does not answer, which has a problem instead.
_FIELDS = ("problem", "target", "arguments", "started_wall_s", "log_dir", "domain_id", "processes")


def _run_table(runs: Sequence[Mapping[str, Any]]) -> Any:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    for title in ("run", "target", "arguments", "since", "processes", "domain"):
        table.add_column(title, overflow="fold")
    for run in runs:
        if run["problem"] is not None:
            table.add_row(Text(run["id"]), Text(run["problem"]))
            continue
        since = time.strftime("%H:%M:%S", time.localtime(run["started_wall_s"]))
        words = (run["id"], run["target"], " ".join(run["arguments"]), since)
        domain = "-" if run["domain_id"] is None else str(run["domain_id"])
        table.add_row(*map(Text, (*words, str(len(run["processes"])), domain)))
    return table


def _print_table(table: Any) -> None:
    from launcher.control.console.process_tables import render
    from launcher.output.stdout import wants_colour

    print(render(table, table_width(), colour=wants_colour(1, os.environ)), flush=True)


def table_width() -> int:
    """Columns of the terminal; tables in a pipe are not truncated."""
    return (os.get_terminal_size(1).columns or 80) if sys.stdout.isatty() else WIDE


# ---- one way to show each kind of answer


def _print_reply(connection: Connection, call: Call, options: Parsed) -> int:
    reply = connection.ask(call.verb.name, call.names, **call.options)
    if options.json:
        print_document(reply.result)
    else:
        print("\n".join(reply.text))
    processes = reply.result.get("processes", [])
    is_done = all(one.get("done", True) for one in processes)
    return ExitCode.OK if is_done else ExitCode.PROCESS_FAILED


def _quit(connection: Connection, call: Call, options: Parsed) -> int:
    code = _print_reply(connection, call, options)
    connection.wait_for_end()
    if not options.json:
        print("the run has ended")
    return code


def _ps(connection: Connection, call: Call, options: Parsed) -> int:
    from launcher.control.answer_lines import notes
    from launcher.control.console.process_tables import details, process_table, stacked

    result = connection.ask(call.verb.name, call.names, **call.options).result
    found = result["processes"]
    if options.json:
        print_document(result)
    elif call.verb.name == "ps":
        _print_table(process_table(found, table_width()))
        for note in notes(result):
            print(note)
    else:
        _print_table(stacked([details(one) for one in found]))
    return ExitCode.OK


def _top(connection: Connection, call: Call, options: Parsed) -> int:
    if options.json:
        for result in connection.follow("top", call.names, **call.options):
            print_line(result)
    elif sys.stdout.isatty() and os.environ.get("TERM") != "dumb":
        from launcher.control.console.top import LiveTop
        from launcher.output.stdout import wants_colour

        LiveTop(connection, call, colour=wants_colour(1, os.environ)).run()
    elif call.options:  # `-f` or `-p`
        for sample in connection.follow("top", call.names, **call.options):
            _print_in_order(sample.get("processes", ()))
    else:
        _print_in_order(connection.ask("ps", call.names).result["processes"])
    return ExitCode.OK


def _print_in_order(found: Sequence[Mapping[str, Any]]) -> None:
    from launcher.control.console.process_tables import process_table
    from launcher.control.console.top import Top

    _print_table(process_table(Top().sorted(found), table_width()))


def _lines(connection: Connection, call: Call, options: Parsed) -> int:
    key, as_line = ("lines", log_line) if call.verb.name == "logs" else ("events", event_line)
    items: Iterable[dict[str, Any]]
    if call.options.get("follow"):
        items = connection.follow(call.verb.name, call.names, **call.options)
    else:
        items = connection.ask(call.verb.name, call.names, **call.options).result[key]
    from launcher.output.stdout import passes_colour

    has_colour = passes_colour(1, os.environ)
    for item in items:
        if options.json:
            print_line(item)
            continue
        line = as_line(item)
        print(line if has_colour else without_colour(line), flush=True)
    return ExitCode.OK


_PRINT: dict[str, Callable[[Connection, Call, Parsed], int]] = {
    "ps": _ps,
    "info": _ps,
    "top": _top,
    "logs": _lines,
    "events": _lines,
    "quit": _quit,
}
