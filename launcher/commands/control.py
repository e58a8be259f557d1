"""`ps`, `top`, `kill`, `stop`, `logs` and so on: a running run, from any other shell."""

from __future__ import annotations

import json
import os
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from launcher.control import verbs
from launcher.control.client import Connection
from launcher.control.format import event_line, log_line
from launcher.control.runs import AnyRun, SilentRun, all_runs, find_run
from launcher.control.verbs import Call, Verb
from launcher.errors import ExitCode, UsageError
from launcher.model.record import Record

WIDE = 1000  # columns of a table that goes into a pipe
RUNS_USAGE = "runs [--json]"
COMMON = """\
  --run ID             which run, where there are several: its id, pid or target, or the
                       beginning of one of them
  --json               for programs: one JSON object, or one a line
  -h, --help           this text"""
NAMES = """\
NAME is a process (`robot_2-4`), its label (`robot_2`), its node (`/fleet/robot_2`), a pattern of
these (`robot_*`), or a namespace, which means all below it (`/fleet`)."""


class Settings(Record):
    """The words that every command takes."""

    run: str | None = None
    as_json: bool = False


def main(words: Sequence[str]) -> int:
    """Carry out the command that `words[0]` names; the exit code."""
    name, *rest = words
    verb = verbs.find(name)
    if _wants_help(rest):
        print(usage(name, verb))
        return ExitCode.OK
    settings, rest = take_settings(name, rest)
    if verb is None:
        return _runs(settings, rest)
    call = verbs.parse(verb, rest)
    looks = name in verbs.LOOKING
    with find_run(settings.run, _complain, looks=looks).connect() as connection:
        try:
            return _SHOWS.get(name, _tell)(connection, call, settings)
        except KeyboardInterrupt:
            if verb.streams:
                return ExitCode.OK  # nothing else ends it
            raise


def usage(name: str, verb: Verb | None) -> str:
    """What `--help` prints."""
    if verb is None:
        return f"usage: python -m launcher {RUNS_USAGE}\n\nList the runs that are going on."
    head, about, *options = verbs.manual(verb)
    lines = [
        f"{head.replace('usage: ', 'usage: python -m launcher ')} [--run ID] [--json]",
        "",
        about,
    ]
    if verb.names != "none":
        lines += ["", NAMES]
    lines += ["", "options:", *options]
    return "\n".join([*lines, COMMON])


def _wants_help(words: Sequence[str]) -> bool:
    before = words[: words.index("--")] if "--" in words else words
    return any(word in ("-h", "--help") for word in before)


def take_settings(name: str, words: Sequence[str]) -> tuple[Settings, list[str]]:
    """(what every command takes, wherever it stands before `--`; the other words); UsageError."""
    run, as_json = None, False
    rest: list[str] = []
    queue = deque(words)
    while queue and queue[0] != "--":
        word = queue.popleft()
        if word == "--run" or word.startswith("--run="):
            run = _run_meant(word, queue)
        elif word == "--json":
            as_json = True
        elif word != "--debug":
            rest.append(word)
    return Settings(run=run, as_json=as_json), _with_text(name, rest, list(queue))


def _run_meant(word: str, queue: deque[str]) -> str:
    _, has_value, value = word.partition("=")
    if not has_value and queue and not queue[0].startswith("--"):
        value = queue.popleft()
    if not value:
        raise UsageError("--run needs the id of a run", hint="python -m launcher runs")
    return value


def _with_text(name: str, rest: list[str], behind: list[str]) -> list[str]:
    """The words as the verb reads them: those of a text, which may look like options, behind `--`.

    `-5` is a text as good as any; `--ru` was meant as an option, UsageError.
    """
    verb = verbs.find(name)
    if verb is None or verb.text is None or not rest:
        return [*rest, *behind]
    meant, *text = rest
    for word in text:
        if word.startswith("--"):
            hint = f"usage: {verb.usage}; a text with '{word}' goes behind --"
            raise UsageError(f"{name} has no option '{word}'", hint=hint)
    return [meant, "--", *text, *behind[1:]]


def _complain(text: str) -> None:
    print(f"note: {text}", file=sys.stderr)


def _print_json(document: Mapping[str, Any]) -> None:
    print(json.dumps(document), flush=True)


def _runs(settings: Settings, words: Sequence[str]) -> int:
    if words:
        raise UsageError(f"runs takes no '{words[0]}'", hint=f"usage: {RUNS_USAGE}")
    found = [_as_document(run) for run in all_runs(_complain)]
    if settings.as_json:
        _print_json({"runs": found})
    elif found:
        _print_table(_run_table(found))
    else:
        print("no run of yours is going on")
    return ExitCode.OK


def _as_document(run: AnyRun) -> dict[str, Any]:
    known = {"id": run.run_id, "pid": run.pid, "socket": str(run.path), "problem": None}
    if isinstance(run, SilentRun):
        return {**dict.fromkeys(_ABOUT), **known, "problem": run.problem}
    return {
        **known,
        "target": run.target,
        "arguments": list(run.arguments),
        "started": run.started,
        "log_dir": run.log_dir,
        "domain_id": run.domain_id,
        "processes": list(run.processes),
    }


_ABOUT = ("target", "arguments", "started", "log_dir", "domain_id", "processes")


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
        since = time.strftime("%H:%M:%S", time.localtime(run["started"]))
        words = (run["id"], run["target"], " ".join(run["arguments"]), since)
        domain = "-" if run["domain_id"] is None else str(run["domain_id"])
        table.add_row(*map(Text, (*words, str(len(run["processes"])), domain)))
    return table


def _print_table(table: Any) -> None:
    from launcher.console.tables import render
    from launcher.engine.output.stdout import wants_colour

    print(render(table, _width(), colour=wants_colour(1, os.environ)), flush=True)


def _width() -> int:
    """Through a pipe, nothing is left out: whoever reads it wants the whole."""
    return (os.get_terminal_size(1).columns or 80) if sys.stdout.isatty() else WIDE


# ---- one way to show each kind of answer


def _tell(connection: Connection, call: Call, settings: Settings) -> int:
    reply = connection.ask(call.verb.name, call.names, **call.options)
    if settings.as_json:
        _print_json(reply.result)
    else:
        print("\n".join(reply.text))
    processes = reply.result.get("processes", [])
    is_done = all(one.get("done", True) for one in processes)
    return ExitCode.OK if is_done else ExitCode.PROCESS_FAILED


def _quit(connection: Connection, call: Call, settings: Settings) -> int:
    code = _tell(connection, call, settings)
    connection.wait_for_end()
    if not settings.as_json:
        print("the run has ended")
    return code


def _ps(connection: Connection, call: Call, settings: Settings) -> int:
    result = connection.ask("ps", call.names).result
    if settings.as_json:
        _print_json(result)
    else:
        from launcher.console.tables import process_table

        _print_table(process_table(result["processes"], _width()))
    return ExitCode.OK


def _info(connection: Connection, call: Call, settings: Settings) -> int:
    result = connection.ask("info", call.names).result
    if settings.as_json:
        _print_json(result)
    else:
        from launcher.console.tables import about, several

        _print_table(several([about(one) for one in result["processes"]]))
    return ExitCode.OK


def _top(connection: Connection, call: Call, settings: Settings) -> int:
    if settings.as_json:
        for result in connection.follow("top", call.names, **call.options):
            _print_json(result)
    elif sys.stdout.isatty() and os.environ.get("TERM") != "dumb":
        from launcher.console.top import LiveTop
        from launcher.engine.output.stdout import wants_colour

        LiveTop(connection, call, colour=wants_colour(1, os.environ)).run()
    elif call.options:  # `-f` or `-p`: who asks for more than one look gets it
        for look in connection.follow("top", call.names, **call.options):
            _print_in_order(look.get("processes", ()))
    else:
        _print_in_order(connection.ask("ps", call.names).result["processes"])
    return ExitCode.OK


def _print_in_order(found: Sequence[Mapping[str, Any]]) -> None:
    from launcher.console.tables import process_table
    from launcher.console.top import Top

    _print_table(process_table(Top().sorted(found), _width()))


def _logs(connection: Connection, call: Call, settings: Settings) -> int:
    _print_all(connection, call, "lines", log_line, settings)
    return ExitCode.OK


def _events(connection: Connection, call: Call, settings: Settings) -> int:
    _print_all(connection, call, "events", event_line, settings)
    return ExitCode.OK


def _print_all(
    connection: Connection,
    call: Call,
    key: str,
    as_line: Callable[[Mapping[str, Any]], str],
    settings: Settings,
) -> None:
    items: Iterable[dict[str, Any]]
    if call.options.get("follow"):
        items = connection.follow(call.verb.name, call.names, **call.options)
    else:
        items = connection.ask(call.verb.name, call.names, **call.options).result[key]
    for item in items:
        print(json.dumps(item) if settings.as_json else as_line(item), flush=True)


_SHOWS: dict[str, Callable[[Connection, Call, Settings], int]] = {
    "ps": _ps,
    "info": _info,
    "top": _top,
    "logs": _logs,
    "events": _events,
    "quit": _quit,
}
