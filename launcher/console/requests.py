"""Talk: a line that a person typed, asked of the run and answered in text."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rich.console import RenderableType
from rich.text import Text

from launcher.console import tables
from launcher.console.tables import process_table
from launcher.control.client import Reply
from launcher.control.format import event_line, log_line
from launcher.control.runs import Run
from launcher.control.socket_directory import ControlError
from launcher.control.verbs import VERBS, Call, find, parse
from launcher.errors import LauncherError, UsageError, nearest

KEYS = (
    ("Tab", "complete a verb, a name, a pattern, a signal"),
    ("Up, Ctrl-R", "lines that were typed before; search in them"),
    ("Ctrl-C", "stop everything; again: do not wait. In top and logs -f: end that"),
    ("Ctrl-D", "the same as quit"),
    ("Ctrl-Z", "suspend; fg goes on"),
)
AS_IT_IS = ("logs", "plan")  # lines that may be copied, or have colours of their own
NOTHING = "(nothing)"


def read_call(line: str) -> Call:
    """What the line asks for; UsageError."""
    try:
        name, *words = shlex.split(line)
    except ValueError as error:
        hint = "quotes come in pairs, as in a shell; \\' is a quote that is meant"
        raise UsageError(f"the line is not finished: {error}", hint=hint) from None
    verb = find(name)
    if verb is None:
        near = nearest(name, [verb.name for verb in VERBS])
        hint = f"did you mean {near}?" if near else "`help` lists what there is"
        raise UsageError(f"there is no verb '{name}'", hint=hint)
    return parse(verb, words)


def follows(call: Call) -> bool:
    """Whether its answer does not end; `top` is live unless it is asked otherwise."""
    return call.verb.streams and (call.verb.name == "top" or bool(call.options.get("follow")))


def answer(run: Run, call: Call, columns: int, *, colour: bool) -> str:
    """Ask, wait, and put into words; errors, too."""
    if call.verb.name == "help" and "topic" not in call.options:
        return tables.render(_help(), columns, colour=colour)
    try:
        with run.connect() as connection:
            reply = connection.ask(call.verb.name, call.names, **call.options)
    except ControlError as error:
        return problem(error, columns, colour=colour)
    if call.verb.name == "events":
        return "\n".join(map(event_line, reply.result["events"])) or NOTHING
    if call.verb.name in AS_IT_IS:
        return "\n".join(reply.text) or NOTHING
    made = _table(call, reply, columns) or Text("\n".join(reply.text) or NOTHING)
    return tables.render(made, columns, colour=colour)


def problem(error: LauncherError, columns: int, *, colour: bool) -> str:
    """The error as it is printed."""
    first, newline, rest = error.render().partition("\n")
    text = Text.assemble((first, "red"), newline, rest)
    return tables.render(text, columns, colour=colour)


def _help() -> RenderableType:
    return tables.pairs([*((verb.usage, verb.help) for verb in VERBS), ("", ""), *KEYS])


def _table(call: Call, reply: Reply, columns: int) -> RenderableType | None:
    found = reply.result.get("processes")
    if call.verb.name == "ps" and found is not None:
        return process_table(found, columns)
    if call.verb.name == "info" and found:
        return tables.several([tables.about(one) for one in found])
    return None


Hear = Callable[[Mapping[str, Any]], None]


def item_text(call: Call, item: Mapping[str, Any]) -> str:
    """An item of `logs -f` or `events -f` as a line."""
    return log_line(item) if call.verb.name == "logs" else event_line(item)


def items(connection: Any, call: Call) -> Iterator[dict[str, Any]]:
    """The items of a call that does not end, till the connection is closed."""
    options = {key: value for key, value in call.options.items() if key != "follow"}
    yield from connection.follow(call.verb.name, call.names, **options)
