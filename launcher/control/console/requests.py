"""A line from the prompt as a request to the run, and the answer as text."""

from __future__ import annotations

import shlex

from rich.console import Group, RenderableType
from rich.text import Text

from launcher.base.errors import LauncherError, UsageError
from launcher.base.program import browse, program, without_program
from launcher.base.run_verb import Call
from launcher.base.synonyms import meant_verb
from launcher.base.verb_table import VERBS as COMMAND_VERBS
from launcher.control.active_runs import ListedRun
from launcher.control.answer_lines import event_line, notes, without_colour
from launcher.control.client import Reply
from launcher.control.console.fault_table import fault_table
from launcher.control.console.process_tables import details, manual, process_table, render, stacked
from launcher.control.verbs import EVERYTHING, VERBS, explained, find, parse
from launcher.posix.socket_directory import ControlError

# Verbs of the command line that are none of a run. The console runs each as a process,
# except a few that have no use there or need the terminal.
SHELL_VERBS = (*(name for name in COMMAND_VERBS if find(name) is None), "runs")
NEEDING_A_SHELL = ("launch", "attach", "agent", "completion")
SHELL_HELP = "runs as in a shell, until Ctrl-C"
CLEAR = "clear"  # carried out by the console itself
CLEAR_HELP = "clear the screen, as Ctrl-L"
KEYS = (
    ("Tab", "complete verbs, names, patterns, options and signals"),
    ("Up, Ctrl-R", "previous lines; search in them"),
    ("F2", "the list of processes: arrows, / searches, Enter shows the log, q goes back"),
    ("F3", "snapshot, of a run with --record"),
    ("w", "and Enter, or w in the list of processes: the page in the browser"),
    (
        "Ctrl-C",
        "stop everything; again: without waiting. In top, logs -f, the list and while a verb of "
        "a shell runs: end these",
    ),
    ("Ctrl-D", "the same as quit"),
    ("Ctrl-Z", "suspend; fg resumes"),
)
AS_IT_IS = ("logs", "plan")  # not wrapped: people copy lines of logs; a plan has colours
NOTHING = "(nothing)"


def runs_here(name: str) -> bool:
    """Whether this is a verb of the command line that the console can run."""
    return name in SHELL_VERBS and name not in NEEDING_A_SHELL


def read_shell_words(line: str) -> list[str] | None:
    """The words of a verb of the command line; None for other lines. UsageError."""
    words = split(line)
    named = words[1:2] if words[0] == "help" else words[:1]
    return words if any(map(runs_here, named)) else None


def read_call(line: str) -> Call:
    """Parse a line; UsageError."""
    name, *words = split(line)
    verb = find(name)
    if verb is None:
        _refuse_shell_verb(name, words)
        known = [*(verb.name for verb in VERBS), *filter(runs_here, SHELL_VERBS), CLEAR]
        hint = meant_verb(name, known) or "`help all` lists all verbs"
        raise UsageError(f"unknown verb '{name}'", hint=hint)
    return parse(verb, words)


def split(line: str) -> list[str]:
    """The words of a line that is not empty; the program's name in front is none. UsageError.

    People paste commands from the documentation. The name alone is `help`.
    """
    try:
        return without_program(shlex.split(line)) or ["help"]
    except ValueError as error:
        hint = "quotes come in pairs, as in a shell; \\' is a literal quote"
        raise UsageError(f"the line is not finished: {error}", hint=hint) from None


def _refuse_shell_verb(name: str, words: list[str]) -> None:
    """UsageError with the command for another shell, such as `launcher attach`."""
    if name in NEEDING_A_SHELL:
        hint = f"in another shell: {program()} {shlex.join((name, *words))}"
        raise UsageError(f"'{name}' is a verb for shells", hint=hint)


def follows(call: Call) -> bool:
    """Whether the answer is a stream: `top`, and verbs with `--follow`."""
    return call.verb.streams and (call.verb.name == "top" or bool(call.options.get("follow")))


def answer(run: ListedRun, call: Call, columns: int, *, colour: bool) -> str:
    """Send the request, wait for the answer and return it, or the error, as text.

    Empty if the run itself writes it here, too.
    """
    if call.verb.name == "help" and call.options["topic"] == EVERYTHING:
        rows = [*((verb.usage, explained(verb)) for verb in VERBS), (CLEAR, CLEAR_HELP)]
        names = ", ".join(sorted({name for name in SHELL_VERBS if runs_here(name)}))
        rows += [("", ""), ("topic list, ...", f"{SHELL_HELP}: {names}"), ("", ""), *KEYS]
        return render(manual(rows, columns), columns, colour=colour)
    try:
        with run.connect() as connection:
            reply = connection.ask(call.verb.name, call.names, **call.options)
    except ControlError as error:
        return problem(error, columns, colour=colour)
    if call.verb.name == "events":
        return "\n".join(map(event_line, reply.result["events"])) or NOTHING
    if call.verb.name == "detach":
        return ""
    if call.verb.name == "web":
        browse(reply.result["link"])
    if call.verb.name in AS_IT_IS:
        text = "\n".join(reply.text) or NOTHING
        return text if colour else without_colour(text)
    made = _table(call, reply, columns) or Text("\n".join(reply.text) or NOTHING)
    return render(made, columns, colour=colour)


def problem(error: LauncherError, columns: int, *, colour: bool) -> str:
    first, newline, rest = error.render().partition("\n")
    text = Text.assemble((first, "red"), newline, rest)
    return render(text, columns, colour=colour)


def _table(call: Call, reply: Reply, columns: int) -> RenderableType | None:
    found = reply.result.get("processes")
    if call.verb.name == "ps" and found is not None:
        return Group(process_table(found, columns), *map(Text, notes(reply.result)))
    if call.verb.name == "faults" and "watching" in reply.result:
        return fault_table(reply.result, columns)
    if call.verb.name == "info" and found:
        return stacked([details(one) for one in found])
    return None
